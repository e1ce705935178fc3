// SPDX-License-Identifier: Apache-2.0
#include "losses/report_json.h"

#include <nlohmann/json.hpp>

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

}  // namespace drape
