// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/photo_overlay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "losses/outline/shape_features.h"

namespace drape {
namespace {

constexpr int kSide = 1400;  // [px] of the longer side of the picture

const cv::Scalar kOutline(20, 110, 230), kDisc(40, 160, 60), kFlat(200, 150, 40),
    kFault(220, 40, 30), kTag(170, 40, 170), kInk(40, 40, 40);

std::vector<std::string> Wrapped(const std::string& text, int width, double size) {
  std::vector<std::string> lines = {""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    int base = 0;
    const cv::Size box = cv::getTextSize(longer, cv::FONT_HERSHEY_SIMPLEX, size, 2, &base);
    if (box.width > width && !lines.back().empty())
      lines.push_back(word);
    else
      lines.back() = longer;
  }
  return lines;
}

class Canvas {
 public:
  Canvas(const PhotoPlanes& planes)
      : scale_(double(kSide) / std::max(planes.rgb.cols, planes.rgb.rows)) {
    cv::resize(planes.rgb, picture_, {}, scale_, scale_,
               scale_ < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  }

  void Curve(const std::vector<cv::Point>& points, const cv::Scalar& color, int width) {
    std::vector<cv::Point> scaled;
    for (const cv::Point& p : points) scaled.push_back(Place(p.x, p.y));
    if (scaled.size() == 1) {
      cv::circle(picture_, scaled[0], width, color, cv::FILLED, cv::LINE_AA);
    } else if (!scaled.empty()) {
      cv::polylines(picture_, scaled, true, color, width, cv::LINE_AA);
    }
  }
  void Ellipse(cv::RotatedRect ellipse) {
    ellipse.center = {float((ellipse.center.x + 0.5) * scale_ - 0.5),
                      float((ellipse.center.y + 0.5) * scale_ - 0.5)};
    ellipse.size.width *= float(scale_);
    ellipse.size.height *= float(scale_);
    cv::ellipse(picture_, ellipse, kDisc, 2, cv::LINE_AA);
    cv::drawMarker(picture_, ellipse.center, kDisc, cv::MARKER_CROSS, 24, 2, cv::LINE_AA);
  }
  // Below the picture.
  void Text(const std::string& text, const cv::Scalar& color) {
    constexpr double kSize = 0.9;
    constexpr int kLine = 38, kMargin = 20;
    const auto lines = Wrapped(text, picture_.cols - 2 * kMargin, kSize);
    const int top = picture_.rows;
    cv::copyMakeBorder(picture_, picture_, 0, kLine * int(lines.size()) + kMargin, 0, 0,
                       cv::BORDER_CONSTANT, cv::Scalar::all(255));
    for (size_t i = 0; i < lines.size(); ++i)
      cv::putText(picture_, lines[i], {kMargin, top + kLine * (int(i) + 1) - 6},
                  cv::FONT_HERSHEY_SIMPLEX, kSize, color, 2, cv::LINE_AA);
  }
  RgbImage Image() const {
    RgbImage image{picture_.cols, picture_.rows, {}};
    for (int row = 0; row < picture_.rows; ++row) {
      const uint8_t* pixels = picture_.ptr<uint8_t>(row);
      image.rgb.insert(image.rgb.end(), pixels, pixels + size_t(3) * picture_.cols);
    }
    return image;
  }

 private:
  cv::Point Place(double column, double row) const {
    return {cvRound((column + 0.5) * scale_ - 0.5), cvRound((row + 0.5) * scale_ - 0.5)};
  }

  double scale_;
  cv::Mat3b picture_;
};

constexpr double kMostScale = 2000;  // [px/m] more shows nothing of a drape

}  // namespace

RgbImage RenderMarks(const PhotoPlanes& planes, const PhotoMarks& marks) {
  Canvas canvas(planes);
  canvas.Curve(marks.flat, kFlat, 1);
  if (marks.disc) canvas.Ellipse(*marks.disc);
  if (marks.tag) {
    std::vector<cv::Point> corners;
    for (const Eigen::Vector2d& p : *marks.tag)
      corners.emplace_back(cvRound(p.x()), cvRound(p.y()));
    canvas.Curve(corners, kTag, 3);
  }
  canvas.Curve(marks.outline, kOutline, 2);
  for (const auto& fault : marks.faults) canvas.Curve(fault, kFault, 4);
  canvas.Text(marks.text, marks.refused ? kFault : kInk);
  return canvas.Image();
}

Rectified Rectify(const cv::Mat1f& coverage, const PhotoPose& pose) {
  constexpr double kMargin = 0.1;  // of the cloth's extent
  const double focal = std::min(pose.focal, kMostScale * pose.eye.z());
  const Eigen::Matrix3d turn = pose.WorldFromCamera();
  const Eigen::Vector3d flip(1, -1, -1);  // x right, y up, z back → x right, y down, z forward
  Eigen::Matrix3d from_image, to_image;
  from_image << 1 / pose.focal, 0, -pose.principal.x() / pose.focal, 0, 1 / pose.focal,
      -pose.principal.y() / pose.focal, 0, 0, 1;
  to_image << focal, 0, 0, 0, focal, 0, 0, 0, 1;
  Eigen::Matrix3d homography = to_image * flip.asDiagonal() * turn * flip.asDiagonal() * from_image;
  Eigen::Vector2d least(HUGE_VAL, HUGE_VAL), most = -least;
  for (int row = 0; row < coverage.rows; ++row)
    for (int col = 0; col < coverage.cols; ++col)
      if (coverage(row, col) > 0.5f) {
        const Eigen::Vector2d p = (homography * Eigen::Vector3d(col, row, 1)).hnormalized();
        least = least.cwiseMin(p);
        most = most.cwiseMax(p);
      }
  const double margin = kMargin * (most - least).maxCoeff();
  const Eigen::Vector2d origin =
      (least.array() - margin).floor().matrix();  // of the cut, from the optical axis
  Rectified result;
  Camera& camera = result.camera;
  camera.kind = CameraKind::kPinhole;
  camera.width = static_cast<int>(std::ceil(most.x() + margin - origin.x()));
  camera.height = static_cast<int>(std::ceil(most.y() + margin - origin.y()));
  camera.eye_height = pose.eye.z();
  camera.eye_x = pose.eye.x();
  camera.eye_y = pose.eye.y();
  camera.field_of_view = 2 * std::atan(0.5 * camera.height / focal);
  camera.cx = -focal * pose.eye.x() / pose.eye.z() - origin.x();
  camera.cy = focal * pose.eye.y() / pose.eye.z() - origin.y();
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = -origin;
  homography = shift * homography;
  cv::Matx33d matrix;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix(i, j) = homography(i, j);
  cv::Mat1f turned;
  cv::warpPerspective(coverage, turned, matrix, {camera.width, camera.height}, cv::INTER_LINEAR);
  result.silhouette = GrayImage(camera.width, camera.height);
  std::transform(turned.begin(), turned.end(), result.silhouette.coverage.begin(),
                 [](float c) { return std::clamp(c, 0.0f, 1.0f); });
  return result;
}

GrayImage RenderProfile(const Eigen::VectorXd& radius) {
  constexpr int kSamples = 4, kFraction = 4;  // bits of a coordinate below the pixel
  const Camera camera;
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius * camera.scale);
  std::vector<cv::Point> points;
  for (Eigen::Index i = 0; i < polygon.cols(); ++i) {
    const double column = (camera.cx + polygon(0, i) + 0.5) * kSamples - 0.5;
    const double row = (camera.cy - polygon(1, i) + 0.5) * kSamples - 0.5;
    points.emplace_back(cvRound(column * (1 << kFraction)), cvRound(row * (1 << kFraction)));
  }
  cv::Mat1b fine = cv::Mat1b::zeros(camera.height * kSamples, camera.width * kSamples);
  cv::fillPoly(fine, std::vector<std::vector<cv::Point>>{points}, 255, cv::LINE_8, kFraction);
  cv::Mat1b coarse;
  cv::resize(fine, coarse, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  GrayImage image(camera.width, camera.height);
  std::transform(coarse.begin(), coarse.end(), image.coverage.begin(),
                 [](uint8_t value) { return value / 255.0f; });
  return image;
}

}  // namespace drape
