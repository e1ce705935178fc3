// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera_io.h"

#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {

nlohmann::ordered_json CameraJson(const Camera& camera) {
  nlohmann::ordered_json json = {{"kind", ToString(camera.kind)},
                                 {"width", camera.width},
                                 {"height", camera.height},
                                 {"cx", camera.cx},
                                 {"cy", camera.cy},
                                 {"px_per_m", camera.pixels_per_metre()}};
  if (camera.kind == CameraKind::kPinhole) {
    json["eye_height_m"] = camera.eye_height;
    json["field_of_view_rad"] = camera.field_of_view;
    json["eye_x_m"] = camera.eye_x;
    json["eye_y_m"] = camera.eye_y;
  }
  return json;
}

Camera CameraFromJson(const nlohmann::json& json, const std::string& where) {
  const JsonInput whole(json, where);
  const JsonInput input = whole.Has("camera") ? whole.At("camera") : whole;
  Camera camera;
  camera.kind = ParseName<CameraKind>(input.At("kind").String(), input.At("kind").Name());
  camera.width = input.At("width").Integer();
  camera.height = input.At("height").Integer();
  camera.cx = input.At("cx").Number();
  camera.cy = input.At("cy").Number();
  if (camera.kind == CameraKind::kOrthographic) {
    camera.scale = input.At("px_per_m").Number();
  } else {
    camera.eye_height = input.At("eye_height_m").Number();
    camera.field_of_view = input.At("field_of_view_rad").Number();
    camera.eye_x = input.Has("eye_x_m") ? input.At("eye_x_m").Number() : 0.0;
    camera.eye_y = input.Has("eye_y_m") ? input.At("eye_y_m").Number() : 0.0;
  }
  camera.Check(where);
  return camera;
}

Camera ReadCamera(const std::string& path) { return CameraFromJson(ReadJsonFile(path), path); }

nlohmann::ordered_json PhotographJson(const PhotographNotes& notes) {
  return {{"dc", notes.coefficient}, {"dc_sd", notes.coefficient_sd}, {"warnings", notes.warnings}};
}

std::optional<PhotographNotes> ReadPhotographNotes(const std::string& path) {
  const nlohmann::json json = ReadJsonFile(path);
  const JsonInput file(json, path);
  if (!file.Has("photograph")) return std::nullopt;
  const JsonInput input = file.At("photograph"), warnings = input.At("warnings");
  PhotographNotes notes{.coefficient = input.At("dc").Number(),
                        .coefficient_sd = input.At("dc_sd").NotNegative(),
                        .warnings = {}};
  warnings.ExpectArray();
  for (int i = 0; i < warnings.Size(); ++i) notes.warnings.push_back(warnings.At(i).String());
  return notes;
}

}  // namespace drape
