// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"
#include "losses/outline/measured_image.h"
#include "tests/attack/inputs/files/file_readers.h"
#include "tests/attack/inputs/pictures.h"
#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {
namespace {

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

}  // namespace

std::vector<Reader> MakeImageReaders(const std::string& valid) {
  const std::vector<uint8_t> pixels = MakeStarPixels();
  return {
      MakeImageReader("png", "a.png", ReadText(valid + "drape.png")),
      MakeImageReader("jpeg", "a.jpg", EncodeJpegAs(pixels, {})),
      MakeImageReader("progressive jpeg", "b.jpg", EncodeJpegAs(pixels, {.progressive = true}))};
}

}  // namespace drape::attack
