// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/metrics.h"

#include <glog/logging.h>

#include <cmath>
#include <numeric>

#include "losses/metrics/hausdorff.h"
#include "losses/outline/hem_estimate.h"
#include "losses/outline/outline.h"

namespace drape {
namespace {

void CheckSameSize(const GrayImage& a, const GrayImage& b) {
  CHECK_EQ(a.width, b.width);
  CHECK_EQ(a.height, b.height);
  CHECK(!a.coverage.empty());
}

}  // namespace

double MeanSquaredError(const GrayImage& a, const GrayImage& b) {
  CheckSameSize(a, b);
  double sum = 0;
  for (size_t i = 0; i < a.coverage.size(); ++i) {
    const double difference = double(a.coverage[i]) - b.coverage[i];
    sum += difference * difference;
  }
  return sum / a.coverage.size();
}

double IntersectionOverUnion(const GrayImage& a, const GrayImage& b, float threshold) {
  CheckSameSize(a, b);
  size_t both = 0, any = 0;
  for (size_t i = 0; i < a.coverage.size(); ++i) {
    const bool in_a = a.coverage[i] >= threshold, in_b = b.coverage[i] >= threshold;
    both += in_a && in_b;
    any += in_a || in_b;
  }
  return any == 0 ? 1.0 : double(both) / any;
}

double CoverageArea(const GrayImage& image, const Camera& camera) {
  const double pixels = std::accumulate(image.coverage.begin(), image.coverage.end(), 0.0);
  return pixels / std::pow(camera.pixels_per_metre(), 2);
}

SilhouetteMetrics CompareSilhouettes(const GrayImage& image, const Eigen::VectorXd& image_radius,
                                     const GrayImage& fitted_image,
                                     const Eigen::VectorXd& fitted_radius, const Camera& camera,
                                     const DrapeDiscs& discs) {
  const Eigen::VectorXd image_metres = VerticalProfile(image_radius, camera, discs);
  const Eigen::VectorXd fitted_metres = VerticalProfile(fitted_radius, camera, discs);
  SilhouetteMetrics metrics;
  metrics.mse = MeanSquaredError(image, fitted_image);
  metrics.iou = IntersectionOverUnion(image, fitted_image);
  metrics.profile_rms = ProfileRms(image_radius, fitted_radius);
  metrics.hausdorff =
      HausdorffOfPolygons(ProfilePolygon(image_metres), ProfilePolygon(fitted_metres));
  metrics.image_area_dc = DrapeCoefficient(CoverageArea(image, camera), discs);
  metrics.fitted_area_dc = DrapeCoefficient(CoverageArea(fitted_image, camera), discs);
  metrics.image = MeasureShape(image_metres, discs);
  metrics.fitted = MeasureShape(fitted_metres, discs);
  return metrics;
}

}  // namespace drape
