// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "losses/camera/camera_io.h"
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/pictures.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

using nlohmann::json;

Reader MakeImageReader(const std::string& name, const std::string& file,
                       const std::string& content) {
  return {.name = name,
          .file = file,
          .content = content,
          .read =
              [](const std::string& path) {
                const MeasuredImage measured =
                    MeasureImage(ReadSilhouette(path), {}, CentreMode::kOutline, {}, path);
                return std::isfinite(measured.quality.drape_coefficient)
                           ? std::string()
                           : "measured a drape coefficient that is not finite";
              },
          .is_json = false};
}

// With what EXIF says of the camera, and with what a comment says of the discs.
Reader MakePhotographReader(const std::string& name, const std::string& file,
                            const std::string& content) {
  return {.name = name,
          .file = file,
          .content = content,
          .read =
              [](const std::string& path) {
                ReadPngDiscs(path);
                const auto photograph = ReadPhotograph(path);
                const RgbImage& image = photograph.image;
                if (image.rgb.size() != 3 * size_t(image.width) * size_t(image.height))
                  return "read a picture of another size than its pixels";
                return std::isfinite(photograph.exif.focal_35mm) ? ""
                                                                 : "read no finite focal length";
              },
          .is_json = false};
}

Reader MakeCameraReader() {
  Camera eye;
  eye.kind = CameraKind::kPinhole;
  json camera = CameraJson(eye);
  camera["photograph"] = PhotographJson({0.4, 0.01, {"the light is uneven"}});
  return {.name = "camera",
          .file = "camera.json",
          .content = camera.dump(),
          .read = [](const std::string& path) {
            ReadPhotographNotes(path);
            const Camera read = ReadCamera(path);
            return std::isfinite(read.pixels_per_metre())
                       ? std::string()
                       : "read a camera whose scale is not finite";
          }};
}

}  // namespace

std::vector<Reader> MakeImageReaders(const std::string& valid) {
  const std::vector<uint8_t> pixels = MakeStarPixels();
  return {MakeImageReader("png", "a.png", ReadText(valid + "drape.png")),
          MakeImageReader("jpeg", "a.jpg", EncodeJpegAs(pixels, {})),
          MakeImageReader("progressive jpeg", "b.jpg", EncodeJpegAs(pixels, {.progressive = true})),
          MakePhotographReader("photograph", "c.jpg", EncodeJpegAs(pixels, {.orientation = 6})),
          MakePhotographReader("photograph png", "c.png", ReadText(valid + "photograph.png")),
          MakeCameraReader()};
}

}  // namespace drape::attack
