// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/observed_drape.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "losses/outline/hem_estimate.h"
#include "losses/outline/outline.h"
#include "losses/silhouette/raster.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kSupersample = 4;
constexpr double kFarthest = 1e6;  // [px] from the corner, where no drape can be

double PixelOrWhite(const GrayImage& image, int column, int row) {
  const bool inside = column >= 0 && row >= 0 && column < image.width && row < image.height;
  return inside ? image.at(column, row) : 0.0;
}

double Bilinear(const GrayImage& image, double column, double row) {
  const int c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
  const double u = column - c, v = row - r;
  return (1 - v) * ((1 - u) * PixelOrWhite(image, c, r) + u * PixelOrWhite(image, c + 1, r)) +
         v * ((1 - u) * PixelOrWhite(image, c, r + 1) + u * PixelOrWhite(image, c + 1, r + 1));
}

}  // namespace

ObservedDrape ObserveImage(const GrayImage& image, const Camera& camera, const DrapeDiscs& discs,
                           const std::string& where) {
  if (image.width != camera.width || image.height != camera.height) {
    throw InputError(where, "image is " + std::to_string(image.width) + "x" +
                                std::to_string(image.height) + ", expected the camera's " +
                                std::to_string(camera.width) + "x" + std::to_string(camera.height));
  }
  Outline outline;
  if (!OutlineFromImage(image, camera, kObservedAngles, &outline)) {
    throw InputError(
        where, "the outline has gaps: no cloth at " + std::to_string(outline.missing.size()) +
                   " of " + std::to_string(kObservedAngles) + " angles about the camera's centre");
  }
  ObservedDrape drape{image, VerticalProfile(outline.radius, camera, discs), {}, discs};
  drape.shape = MeasureShape(drape.radius, discs);
  return drape;
}

ObservedDrape ObserveSurface(const ObjSurface& surface, const Camera& camera,
                             const DrapeDiscs& discs, const std::string& where) {
  Eigen::Matrix2Xd points;
  if (!ProjectVertices(surface.x, camera, &points) || points.cwiseAbs().maxCoeff() > kFarthest)
    throw InputError(where, "a vertex is not in front of the camera");
  return ObserveImage(Rasterize(surface, camera, kSupersample), camera, discs, where);
}

ObservedDrape ObserveDisc(double radius, const Camera& camera, const DrapeDiscs& discs) {
  CHECK_GT(radius, 0);
  const double radius_px = radius * camera.pixels_per_metre();
  GrayImage image(camera.width, camera.height);
  constexpr int kSamples = kSupersample * kSupersample;
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      int inside = 0;
      for (int i = 0; i < kSamples; ++i) {
        const double x = col - camera.cx + (i % kSupersample + 0.5) / kSupersample - 0.5;
        const double y = row - camera.cy + (i / kSupersample + 0.5) / kSupersample - 0.5;
        inside += x * x + y * y <= radius_px * radius_px;
      }
      image.at(col, row) = static_cast<float>(inside) / kSamples;
    }
  }
  return ObserveImage(image, camera, discs, "disc");
}

GrayImage TurnedImage(const GrayImage& image, const Camera& camera, double rotation,
                      bool mirrored) {
  const double c = std::cos(rotation), s = std::sin(rotation), sign = mirrored ? -1 : 1;
  GrayImage turned(image.width, image.height);
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const double x = col - camera.cx, y = camera.cy - row;
      const double from_x = c * x + s * y, from_y = sign * (c * y - s * x);
      turned.at(col, row) =
          static_cast<float>(Bilinear(image, camera.cx + from_x, camera.cy - from_y));
    }
  }
  return turned;
}

GrayImage MovedImage(const GrayImage& image, const Camera& from, const Camera& to) {
  GrayImage moved(image.width, image.height);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      moved.at(col, row) =
          static_cast<float>(Bilinear(image, col + from.cx - to.cx, row + from.cy - to.cy));
  return moved;
}

void MeanImage::Add(const GrayImage& image) {
  if (count_ == 0) {
    first_ = image;
    sum_ = Eigen::VectorXd::Zero(image.coverage.size());
  }
  CHECK(image.width == first_.width && image.height == first_.height);
  sum_ += Eigen::Map<const Eigen::VectorXf>(image.coverage.data(), sum_.size()).cast<double>();
  ++count_;
}

GrayImage MeanImage::Mean() const {
  CHECK_GT(count_, 0);
  GrayImage mean(first_.width, first_.height);
  Eigen::Map<Eigen::VectorXf>(mean.coverage.data(), sum_.size()) = (sum_ / count_).cast<float>();
  return mean;
}

}  // namespace drape
