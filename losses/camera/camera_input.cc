// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/camera_input.h"

#include <cmath>
#include <filesystem>

#include "losses/camera/camera.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

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
