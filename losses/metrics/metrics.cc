// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/metrics.h"

#include <glog/logging.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "losses/metrics/hausdorff.h"
#include "losses/outline/hem_estimate.h"
#include "losses/outline/outline.h"
#include "physics/simulation/statics/modes.h"

namespace drape {
namespace {

void CheckSameSize(const GrayImage& a, const GrayImage& b) {
  CHECK_EQ(a.width, b.width);
  CHECK_EQ(a.height, b.height);
  CHECK(!a.coverage.empty());
}

nlohmann::ordered_json IntervalJson(const IntervalSkill& skill) {
  return {{"nominal", skill.nominal}, {"coverage", skill.coverage}, {"width", skill.width}};
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

nlohmann::ordered_json QualityJson(const ImageQuality& quality) {
  const Segmentation& segmentation = quality.segmentation;
  return {{"scale", quality.scale_given ? "given" : "of the published images"},
          {"centre", ToString(quality.centre)},
          {"centre_offset_px", quality.centre_offset},
          {"centre_error_px", quality.centre_error},
          {"dc", quality.drape_coefficient},
          {"radius_min_m", quality.radius_min},
          {"radius_max_m", quality.radius_max},
          {"overhanging_share", quality.overhanging},
          {"photograph", segmentation.rescaled},
          {"contrast", segmentation.cloth - segmentation.background},
          {"cut_px", CountPixels(segmentation.cut)},
          {"filled_px", CountPixels(segmentation.filled)},
          {"notes", quality.notes}};
}

nlohmann::ordered_json MetricsJson(const SilhouetteMetrics& metrics) {
  return {{"mse", metrics.mse},
          {"iou", metrics.iou},
          {"profile_rms_px", metrics.profile_rms},
          {"outline_hausdorff_m", metrics.hausdorff},
          {"dc_image", metrics.image.drape_coefficient},
          {"dc_fit", metrics.fitted.drape_coefficient},
          {"folds_image", metrics.image.folds},
          {"folds_fit", metrics.fitted.folds}};
}

nlohmann::ordered_json StabilityJson(const Eigen::VectorXd& lowest_eigenvalues) {
  const bool known = lowest_eigenvalues.size() > 0, stable = IsStable(lowest_eigenvalues);
  nlohmann::ordered_json json = {
      {"stable", known ? nlohmann::ordered_json(stable) : nullptr},
      {"lowest_eigenvalues_per_s2",
       std::vector<double>(lowest_eigenvalues.begin(), lowest_eigenvalues.end())},
      {"lowest_frequency_hz", nullptr}};
  if (stable) json["lowest_frequency_hz"] = std::sqrt(lowest_eigenvalues[0]) / (2.0 * M_PI);
  return json;
}

nlohmann::ordered_json ScoreJson(const DistributionScore& score) {
  nlohmann::ordered_json json = {{"observed", score.observed},
                                 {"mean_image_mse", score.mean_image_mse},
                                 {"feature_energy_score", score.feature_energy},
                                 {"outline_energy_score_m", score.outline_energy}};
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureScore& f = score.features[k];
    json["features"][kFeatureNames[k]] = {
        {"observed_mean", f.observed_mean},    {"predicted_mean", f.predicted_mean},
        {"predicted_sd", f.predicted_sd},      {"crps", f.crps},
        {"interval_50", IntervalJson(f.half)}, {"interval_90", IntervalJson(f.ninety)}};
  }
  return json;
}

}  // namespace drape
