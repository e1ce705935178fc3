// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera.h"

#include <glog/logging.h>

#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

void Require(bool holds, const std::string& where, const char* field, double value,
             const char* expected) {
  if (!holds) throw InputError(where, Format("%s = %g, expected %s", field, value, expected));
}

}  // namespace

Camera CameraAbove(const DrapeDiscs& discs) {
  Camera camera;
  const double larger = discs.specimen / DrapeDiscs().specimen;
  if (larger <= 1.0) return camera;
  camera.width = camera.height = 2 * static_cast<int>(std::ceil(0.5 * larger * camera.width));
  camera.cx = camera.cy = 0.5 * (camera.width - 1);
  return camera;
}

void Camera::Check(const std::string& where) const {
  Require(width >= 16, where, "camera_width", width, ">= 16 px");
  Require(height >= 16, where, "camera_height", height, ">= 16 px");
  constexpr double kFarthest = 1e6;      // [px]
  constexpr double kLargestScale = 1e7;  // [px/m]
  Require(std::abs(cx) <= kFarthest, where, "camera_cx", cx, "a column from -1e6 to 1e6");
  Require(std::abs(cy) <= kFarthest, where, "camera_cy", cy, "a row from -1e6 to 1e6");
  if (kind == CameraKind::kPinhole) {
    Require(eye_height > 0 && eye_height <= 1e3, where, "eye_height", eye_height,
            "more than 0, up to 1000 m");
    Require(field_of_view > 0 && field_of_view < M_PI, where, "field_of_view", field_of_view,
            "between 0 and pi rad");
    Require(pixels_per_metre() <= kLargestScale, where, "field_of_view", field_of_view,
            "so wide that a metre has at most 1e7 px");
    constexpr double kFarthestEye = 100;  // [m]
    Require(std::abs(eye_x) <= kFarthestEye, where, "eye_x", eye_x, "-100 to 100 m");
    Require(std::abs(eye_y) <= kFarthestEye, where, "eye_y", eye_y, "-100 to 100 m");
  } else {
    Require(scale >= 1 && scale <= kLargestScale, where, "camera_scale", scale, "1 to 1e7 px/m");
  }
}

bool ProjectVertices(const Eigen::VectorXd& x, const Camera& camera,
                     Eigen::Matrix2Xd* image_points) {
  CHECK_EQ(x.size() % 3, 0);
  const Projection projection = camera.projection();
  image_points->resize(2, x.size() / 3);
  for (int i = 0; i < image_points->cols(); ++i) {
    if (!projection.IsInFront(&x[3 * i])) return false;
    projection.Project(&x[3 * i], image_points->col(i).data());
  }
  return x.allFinite() && image_points->allFinite();
}

Eigen::VectorXd TurnedAboutZ(const Eigen::VectorXd& x, double rotation, bool mirrored) {
  CHECK_EQ(x.size() % 3, 0);
  const double c = std::cos(rotation), s = std::sin(rotation), sign = mirrored ? -1 : 1;
  Eigen::VectorXd turned = x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    turned[i] = c * x[i] - s * sign * x[i + 1];
    turned[i + 1] = s * x[i] + c * sign * x[i + 1];
  }
  return turned;
}

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
