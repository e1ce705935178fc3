// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera.h"

#include <glog/logging.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

void Require(bool holds, const std::string& where, const char* field, double value,
             const char* expected) {
  if (!holds) throw InputError(where, Format("%s = %g, expected %s", field, value, expected));
}

constexpr const char* kSpecimen = "specimen_diameter_m";
constexpr const char* kSupport = "support_diameter_m";

std::optional<DrapeDiscs> DiscsOfJson(const std::string& path) {
  const nlohmann::json json = ReadJsonFile(path);
  if (!json.is_object() || !json.contains(kSpecimen)) return std::nullopt;
  const JsonInput input(json, path);
  const DrapeDiscs discs{input.At(kSpecimen).Number() / 2, input.At(kSupport).Number() / 2};
  if (!(discs.support > 0.0 && discs.support < discs.specimen))
    throw InputError(path, "found " + ToString(discs) +
                               ", expected a support that is smaller than the specimen");
  return discs;
}

DrapeDiscs WithGiven(const DiscsInput& input, DrapeDiscs discs) {
  if (!std::isnan(input.specimen)) discs.specimen = input.specimen / 2;
  if (!std::isnan(input.support)) discs.support = input.support / 2;
  return discs;
}

constexpr const char* kBeside = "beside";

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool HasUsualSize(const GrayImage& image, const DrapeDiscs& discs) {
  const Camera usual = CameraAbove(discs);
  return image.width == usual.width && image.height == usual.height;
}

// The file alone says what the camera is.
void RequireAlone(const CameraInput& input) {
  const bool more = input.kind != CameraKind::kOrthographic || input.width != 0 ||
                    input.height != 0 || input.gives_scale() || input.gives_centre();
  if (more)
    throw InputError("option 'camera_file'",
                     "found beside other options of the camera, expected the file alone");
}

Camera ReadCameraOfImage(const CameraInput& input, const GrayImage& image,
                         const std::string& where) {
  RequireAlone(input);
  const std::string file = input.FileFor(where);
  const Camera camera = ReadCamera(file);
  if (camera.width != image.width || camera.height != image.height)
    throw InputError(where, "image is " + SizeText(image.width, image.height) + " px, expected " +
                                SizeText(camera.width, camera.height) + " as in " + file);
  return camera;
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
  image_points->resize(2, x.size() / 3);
  for (int i = 0; i < image_points->cols(); ++i) {
    if (!camera.IsInFront(&x[3 * i])) return false;
    camera.Project(&x[3 * i], image_points->col(i).data());
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

Camera ReadCamera(const std::string& path) {
  const nlohmann::json json = ReadJsonFile(path);
  const JsonInput whole(json, path);
  return ReadCamera(whole.Has("camera") ? whole.At("camera") : whole);
}

Camera ReadCamera(const JsonInput& input) {
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
  camera.Check(input.Name());
  return camera;
}

std::optional<int> ParseWarp(const std::string& text, const std::string& where) {
  if (text == kUnknownWarp) return std::nullopt;
  if (text == "up") return 90;
  if (text == "right") return 0;
  int degrees = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, degrees);
  if (error != std::errc() || stop != end || std::abs(degrees) > 360)
    throw InputError(where, "found '" + text +
                                "', expected up, right, unknown or whole degrees from -360 to 360, "
                                "counter-clockwise from the right");
  return (degrees + 360) % 180;
}

std::string ReadWarp(const std::string& path) {
  const nlohmann::json json = ReadJsonFile(path);
  const JsonInput file(json, path);
  if (!file.Has("warp")) return kUnknownWarp;
  const JsonInput warp = file.At("warp");
  ParseWarp(warp.String(), warp.Name());
  return warp.String();
}

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

std::optional<DrapeDiscs> StoredDiscs(const std::string& file) {
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const std::string extension = std::filesystem::path(file).extension();
  if (extension == ".obj") return ReadObjDiscs(file);
  if (extension == ".json") return DiscsOfJson(file);
  return ReadPngDiscs(file);
}

DrapeDiscs FindDiscs(const DiscsInput& input, const std::vector<std::string>& files) {
  std::optional<DrapeDiscs> found;
  std::string first;
  for (const std::string& file : files) {
    const std::optional<DrapeDiscs> stored = StoredDiscs(file);
    if (!stored) continue;
    if (WithGiven(input, *stored) != *stored)
      throw InputError(file, "is of a specimen of " + ToString(*stored) + ", expected " +
                                 ToString(WithGiven(input, *stored)) +
                                 " as options 'specimen' and 'support' say");
    if (found && *found != *stored)
      throw InputError(file, "is of a specimen of " + ToString(*stored) + ", expected " +
                                 ToString(*found) + " as " + first +
                                 ": drapes of different sizes cannot be compared");
    if (!found) first = file;
    found = stored;
  }
  const DrapeDiscs discs = WithGiven(input, found.value_or(DrapeDiscs()));
  if (!(discs.support < discs.specimen))
    throw InputError("option 'support'", "found " + ToString(discs) +
                                             ", expected a support that is smaller than the "
                                             "specimen");
  return discs;
}

DiscsInput GivenDiscs(const DrapeDiscs& discs) { return {2 * discs.specimen, 2 * discs.support}; }

nlohmann::ordered_json DiscsJson(const DrapeDiscs& discs) {
  return {{kSpecimen, 2 * discs.specimen}, {kSupport, 2 * discs.support}};
}

double ScaleInput::Find(const std::string& path) const {
  constexpr double kLeastPixels = 20, kMillimetre = 1e-3;
  const std::string where = "option 'ruler'";
  if (ruler.empty()) return ReadPixelsPerMetre(path);
  const double pixels =
      ruler.size() == 5 ? std::hypot(ruler[2] - ruler[0], ruler[3] - ruler[1]) : 0.0;
  if (dpi || !(pixels >= kLeastPixels && ruler[4] > 0.0))
    throw InputError(where, Format("found %zu numbers and points %.4g px apart, expected "
                                   "X1,Y1,X2,Y2,LENGTH_MM without dpi, of points at least %g px "
                                   "apart",
                                   ruler.size(), pixels, kLeastPixels));
  CheckUsual(where, ruler[4], "mm", 10, 2000);
  return pixels / (kMillimetre * ruler[4]);
}

std::string CameraInput::FileFor(const std::string& image) const {
  if (file != kBeside) return file;
  return std::filesystem::path(image).parent_path() / "camera.json";
}
bool CameraInput::gives_scale() const {
  return !std::isnan(scale) || !std::isnan(image_width_mm) || picture.given();
}
bool CameraInput::gives_centre() const { return !std::isnan(cx) || !std::isnan(cy); }

Camera MakeCamera(const CameraInput& input, const DrapeDiscs& discs) {
  constexpr double kMillimetre = 1e-3;
  if (input.gives_camera()) {
    RequireAlone(input);
    if (input.file == kBeside)
      throw InputError("option 'camera_file'", "found beside without an image, expected a file");
    return ReadCamera(input.file);
  }
  if (!std::isnan(input.scale) + !std::isnan(input.image_width_mm) + input.picture.given() > 1)
    throw InputError("option 'image_width_mm'",
                     "found two of camera_scale, image_width_mm, dpi and ruler, expected one");
  if (input.picture.given())
    throw InputError("option 'dpi' or 'ruler'", "found without a picture, expected camera_scale");
  Camera camera = CameraAbove(discs);
  camera.kind = input.kind;
  if (input.width != 0) camera.width = input.width;
  if (input.height != 0) camera.height = input.height;
  camera.cx = std::isnan(input.cx) ? 0.5 * (camera.width - 1) : input.cx;
  camera.cy = std::isnan(input.cy) ? 0.5 * (camera.height - 1) : input.cy;
  if (!std::isnan(input.scale)) camera.scale = input.scale;
  if (!std::isnan(input.image_width_mm))
    camera.scale = camera.width / (kMillimetre * input.image_width_mm);
  camera.Check("camera");
  return camera;
}

Camera MakeCamera(const CameraInput& input, const GrayImage& image, const DrapeDiscs& discs,
                  const std::string& where) {
  if (input.gives_camera()) return ReadCameraOfImage(input, image, where);
  CameraInput sized = input;
  if (sized.width == 0) sized.width = image.width;
  if (sized.height == 0) sized.height = image.height;
  const std::string size = SizeText(image.width, image.height);
  if (sized.width != image.width || sized.height != image.height)
    throw InputError(where, "image is " + size + " px, expected " +
                                SizeText(sized.width, sized.height) +
                                " (camera_width, "
                                "camera_height)");
  if (!HasUsualSize(image, DrapeDiscs()) && input.kind == CameraKind::kPinhole)
    throw InputError(where, "image is " + size +
                                " px, expected 256x256: camera = pinhole is that "
                                "of the published code");
  if (!HasUsualSize(image, discs) && !input.gives_scale())
    throw InputError(where, "image is " + size +
                                " px and its scale is not given, expected "
                                "image_width_mm, the width that it shows in the support plane, "
                                "camera_scale [px/m], ruler or dpi");
  if (input.picture.given() && std::isnan(input.scale) && std::isnan(input.image_width_mm)) {
    sized.scale = input.picture.Find(where);
    sized.picture = {};
  }
  return MakeCamera(sized, discs);
}

}  // namespace drape
