// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/overlay.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "losses/outline/outline.h"

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr double kClothGray = 150, kBackgroundGray = 255;
constexpr int kCircleAngles = 360;

void Blend(RgbImage* picture, int column, int row, const Color& color, double alpha) {
  if (column < 0 || row < 0 || column >= picture->width || row >= picture->height) return;
  uint8_t* rgb = &picture->rgb[3 * (size_t(row) * picture->width + column)];
  for (int c = 0; c < 3; ++c) {
    rgb[c] = static_cast<uint8_t>(std::lround(rgb[c] + alpha * (color[c] - rgb[c])));
  }
}

double DistanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d e = b - a;
  const double length2 = e.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(e) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * e).norm();
}

// Draws an anti-aliased closed polygon. The opacity is collected over all segments first, so that
// joints are not painted twice.
void RenderPolygon(const Eigen::Matrix2Xd& points, double line_width, const Color& color,
                   RgbImage* picture) {
  std::vector<float> alpha(size_t(picture->width) * picture->height, 0);
  const double reach = 0.5 * line_width + 0.5;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Vector2d a = points.col(i), b = points.col((i + 1) % points.cols());
    const Vector2d min = (a.cwiseMin(b).array() - reach).cwiseMax(0.0);
    const Vector2d size(picture->width - 1, picture->height - 1);
    const Vector2d max = (a.cwiseMax(b).array() + reach).min(size.array());
    for (int row = static_cast<int>(std::ceil(min.y())); row <= max.y(); ++row) {
      for (int col = static_cast<int>(std::ceil(min.x())); col <= max.x(); ++col) {
        const double cover = std::clamp(reach - DistanceToSegment({col, row}, a, b), 0.0, 1.0);
        float& pixel = alpha[size_t(row) * picture->width + col];
        pixel = std::max(pixel, static_cast<float>(cover));
      }
    }
  }
  for (size_t i = 0; i < alpha.size(); ++i) {
    if (alpha[i] > 0) Blend(picture, i % picture->width, i / picture->width, color, alpha[i]);
  }
}

void RenderProfile(const Eigen::VectorXd& radius, const Camera& camera, int upscale,
                   double line_width, const Color& color, RgbImage* picture) {
  CHECK_GE(radius.size(), 3);
  CHECK(radius.allFinite());
  Eigen::Matrix2Xd points = ProfilePolygon(radius);
  points.row(0) = ((camera.cx + points.row(0).array() + 0.5) * upscale - 0.5).matrix();
  points.row(1) = ((camera.cy - points.row(1).array() + 0.5) * upscale - 0.5).matrix();
  RenderPolygon(points, line_width, color, picture);
}

RgbImage PaleUpscaled(const GrayImage& image, int upscale) {
  RgbImage picture{image.width * upscale, image.height * upscale, {}};
  picture.rgb.reserve(size_t(3) * picture.width * picture.height);
  for (int row = 0; row < picture.height; ++row) {
    for (int col = 0; col < picture.width; ++col) {
      const double c = image.at(col / upscale, row / upscale);
      const double gray = kBackgroundGray + c * (kClothGray - kBackgroundGray);
      picture.rgb.insert(picture.rgb.end(), 3, static_cast<uint8_t>(std::lround(gray)));
    }
  }
  return picture;
}

struct Line {
  Eigen::VectorXd radius;  // [px]
  Color color;
  double relative_width;
};

Line Circle(double radius, const Camera& camera, const Color& color) {
  return {Eigen::VectorXd::Constant(kCircleAngles, radius * camera.pixels_per_metre()), color, 0.5};
}

// The first line is drawn last, over the others.
RgbImage RenderLines(const GrayImage& image, const Camera& camera, const std::vector<Line>& lines,
                     const OverlayOptions& options) {
  constexpr int kSize = 1000;         // [px] of a picture that needs no enlargement
  constexpr double kLineShare = 500;  // a line is this part of the width of a larger picture
  CHECK_GE(options.upscale, 0);
  CHECK_GE(options.line_width, 0);
  const int upscale = options.upscale > 0
                          ? options.upscale
                          : std::clamp(kSize / std::max(image.width, image.height), 1, 3);
  const double line_width = options.line_width > 0
                                ? options.line_width
                                : std::max(2.0, image.width * upscale / kLineShare);
  RgbImage picture = PaleUpscaled(image, upscale);
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    RenderProfile(line->radius, camera, upscale, line->relative_width * line_width, line->color,
                  &picture);
  return picture;
}

}  // namespace

RgbImage RenderOverlay(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                       const Eigen::VectorXd& fitted_radius, const Camera& camera,
                       const DrapeDiscs& discs, const OverlayOptions& options) {
  return RenderLines(image, camera,
                     {{fitted_radius, options.fitted, 1.0},
                      {measured_radius, options.measured, 1.0},
                      Circle(discs.support, camera, options.support)},
                     options);
}

RgbImage RenderMeasurement(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                           const Camera& camera, const DrapeDiscs& discs,
                           const OverlayOptions& options) {
  return RenderLines(image, camera,
                     {{measured_radius, options.measured, 1.0},
                      Circle(discs.specimen, camera, options.flat),
                      Circle(discs.support, camera, options.support)},
                     options);
}

}  // namespace drape
