// SPDX-License-Identifier: Apache-2.0
#include "losses/report_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "physics/modes.h"

namespace drape {

nlohmann::ordered_json CameraJson(const Camera& camera) {
  nlohmann::ordered_json json = {{"kind", CameraKindName(camera.kind)},
                                 {"width", camera.width},
                                 {"height", camera.height},
                                 {"cx", camera.cx},
                                 {"cy", camera.cy},
                                 {"px_per_m", camera.pixels_per_metre()}};
  if (camera.kind == CameraKind::kPinhole) {
    json["eye_height_m"] = camera.eye_height;
    json["field_of_view_rad"] = camera.field_of_view;
  }
  return json;
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

}  // namespace drape
