// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"

namespace drape {

// A camera as reports hold it and as a file of its own: kind, width, height, cx, cy [px]; px_per_m
// in the support plane; of a pinhole also eye_height_m, field_of_view_rad, eye_x_m and eye_y_m.
nlohmann::ordered_json CameraJson(const Camera& camera);

// The camera of such an object, or of an object that holds it as "camera". Throws InputError
// (prefix `where`) for a key that is missing and a value that Camera::Check refuses.
Camera CameraFromJson(const nlohmann::json& json, const std::string& where);

// The camera of a file that holds such an object, or of one that holds it as "camera", as the
// files of drape_photo do. Throws InputError also for a file that cannot be read.
Camera ReadCamera(const std::string& path);

// What drape_photo says of a photograph beside its camera, for whoever uses the silhouette.
struct PhotographNotes {
  double coefficient = 0.0;     // estimated drape coefficient
  double coefficient_sd = 0.0;  // its standard deviation
  std::vector<std::string> warnings;
};
// {"dc", "dc_sd", "warnings"}, the member "photograph" of a camera file.
nlohmann::ordered_json PhotographJson(const PhotographNotes& notes);
// Of such a file; none where it does not come from a photograph. Throws InputError for a file that
// cannot be read and for a member of another form.
std::optional<PhotographNotes> ReadPhotographNotes(const std::string& path);

}  // namespace drape
