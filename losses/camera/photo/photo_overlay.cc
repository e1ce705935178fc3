// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/photo_overlay.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <sstream>

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

}  // namespace drape
