// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/pictures.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

using nlohmann::json;

std::string MeasureSilhouette(const std::string& path) {
  const MeasuredImage measured =
      MeasureImage(ReadSilhouette(path), {}, CentreMode::kOutline, {}, path);
  return std::isfinite(measured.quality.drape_coefficient)
             ? ""
             : "measured a drape coefficient that is not finite";
}

// With what EXIF says of the camera, and with what a comment says of the discs.
std::string ReadWholePhotograph(const std::string& path) {
  ReadPngDiscs(path);
  const auto photograph = ReadPhotograph(path);
  const RgbImage& image = photograph.image;
  if (image.rgb.size() != 3 * size_t(image.width) * size_t(image.height))
    return "read a picture of another size than its pixels";
  return std::isfinite(photograph.exif.focal_35mm) ? "" : "read no finite focal length";
}

Reader MakeCameraReader() {
  Camera eye;
  eye.kind = CameraKind::kPinhole;
  json camera = CameraJson(eye);
  camera.update(DiscsJson(DrapeDiscs()));
  camera["warp"] = "-45";
  camera["photograph"] = PhotographJson({0.4, 0.01, {"the light is uneven"}});
  return {.name = "camera",
          .file = "camera.json",
          .content = camera.dump(),
          .read = [](const std::string& path) {
            ReadPhotographNotes(path);
            ParseWarp(ReadWarp(path), path);
            StoredDiscs(path);
            const Camera read = ReadCamera(path);
            return std::isfinite(read.pixels_per_metre())
                       ? std::string()
                       : "read a camera whose scale is not finite";
          }};
}

}  // namespace

std::vector<Reader> MakeImageReaders(const std::string& valid) {
  const std::vector<uint8_t> pixels = MakeStarPixels();
  const auto picture = [](const char* name, const char* file, const std::string& content,
                          std::string (*read)(const std::string&)) {
    return Reader{.name = name, .file = file, .content = content, .read = read, .is_json = false};
  };
  const std::string progressive = EncodeJpegAs(pixels, {.progressive = true});
  const std::string turned = EncodeJpegAs(pixels, {.orientation = 6});
  return {
      picture("png", "a.png", ReadText(valid + "drape.png"), MeasureSilhouette),
      picture("jpeg", "a.jpg", EncodeJpegAs(pixels, {}), MeasureSilhouette),
      picture("progressive jpeg", "b.jpg", progressive, MeasureSilhouette),
      picture("photograph", "c.jpg", turned, ReadWholePhotograph),
      picture("photograph png", "c.png", ReadText(valid + "photograph.png"), ReadWholePhotograph),
      MakeCameraReader()};
}

}  // namespace drape::attack
