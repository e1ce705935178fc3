// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera_input.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {

namespace {

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

std::string CameraInput::FileFor(const std::string& image) const {
  if (file != kBeside) return file;
  return std::filesystem::path(image).parent_path() / "camera.json";
}
bool CameraInput::gives_scale() const { return !std::isnan(scale) || !std::isnan(image_width_mm); }
bool CameraInput::gives_centre() const { return !std::isnan(cx) || !std::isnan(cy); }

Camera MakeCamera(const CameraInput& input, const DrapeDiscs& discs) {
  constexpr double kMillimetre = 1e-3;
  if (input.gives_camera()) {
    RequireAlone(input);
    if (input.file == kBeside)
      throw InputError("option 'camera_file'", "found beside without an image, expected a file");
    return ReadCamera(input.file);
  }
  if (!std::isnan(input.scale) && !std::isnan(input.image_width_mm))
    throw InputError("option 'image_width_mm'", "found beside camera_scale, expected one of both");
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
                                "image_width_mm, the width that it shows in the support plane, or "
                                "camera_scale [px/m]");
  return MakeCamera(sized, discs);
}

}  // namespace drape
