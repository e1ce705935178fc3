// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/report_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "physics/simulation/statics/modes.h"

namespace drape {
namespace {

nlohmann::ordered_json IntervalJson(const IntervalSkill& skill) {
  return {{"nominal", skill.nominal}, {"coverage", skill.coverage}, {"width", skill.width}};
}

}  // namespace

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
