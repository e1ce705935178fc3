// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/rectified.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "losses/outline/shape_features.h"

namespace drape {
namespace {

constexpr double kMostScale = 2000;  // [px/m] more shows nothing of a drape

}  // namespace

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
