// SPDX-License-Identifier: Apache-2.0
#include "tests/losses/photo/rendered/photo_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/losses/image/encode.h"

namespace drape {
namespace {

void Append(std::vector<uint8_t>* bytes, uint32_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes->push_back(static_cast<uint8_t>(value >> (8 * i)));
}
void AppendEntry(std::vector<uint8_t>* bytes, uint32_t tag, uint32_t type, uint32_t value) {
  constexpr uint32_t kShort = 3;
  Append(bytes, tag, 2);
  Append(bytes, type, 2);
  Append(bytes, 1, 4);
  Append(bytes, type == kShort ? value << 16 : value, 4);
}

std::vector<uint8_t> ExifSegment(const PhotoScene& scene) {
  constexpr uint32_t kShort = 3, kLong = 4, kSecond = 38;
  std::vector<uint8_t> tiff = {'M', 'M', 0, 42, 0, 0, 0, 8};
  Append(&tiff, 2, 2);
  AppendEntry(&tiff, 0x0112, kShort, static_cast<uint32_t>(scene.orientation));
  AppendEntry(&tiff, 0x8769, kLong, kSecond);
  Append(&tiff, 0, 4);
  Append(&tiff, 3, 2);
  AppendEntry(&tiff, 0xA002, kLong, static_cast<uint32_t>(scene.width));
  AppendEntry(&tiff, 0xA003, kLong, static_cast<uint32_t>(scene.height));
  AppendEntry(&tiff, 0xA405, kShort, static_cast<uint32_t>(std::lround(scene.focal_35mm)));
  Append(&tiff, 0, 4);
  std::vector<uint8_t> segment = {0xFF, 0xE1};
  Append(&segment, static_cast<uint32_t>(tiff.size() + 8), 2);
  for (const char c : {'E', 'x', 'i', 'f', '\0', '\0'}) segment.push_back(static_cast<uint8_t>(c));
  segment.insert(segment.end(), tiff.begin(), tiff.end());
  return segment;
}

// The picture that a viewer turns to `image` by the EXIF orientation: 3, 6 or 8.
RgbImage AsHeld(const RgbImage& image, int orientation) {
  if (orientation == 1) return image;
  const bool upside_down = orientation == 3;
  RgbImage held{upside_down ? image.width : image.height, upside_down ? image.height : image.width,
                std::vector<uint8_t>(image.rgb.size())};
  for (int row = 0; row < held.height; ++row)
    for (int col = 0; col < held.width; ++col) {
      const int from_row = upside_down        ? image.height - 1 - row
                           : orientation == 8 ? image.height - 1 - col
                                              : col;
      const int from_col = upside_down        ? image.width - 1 - col
                           : orientation == 8 ? row
                                              : image.width - 1 - row;
      std::copy_n(&image.rgb[3 * (size_t(from_row) * image.width + from_col)], 3,
                  &held.rgb[3 * (size_t(row) * held.width + col)]);
    }
  return held;
}

}  // namespace

std::vector<uint8_t> PhotoFile(const PhotoScene& scene, const RgbImage& image) {
  PhotoScene held = scene;
  const RgbImage stored = AsHeld(image, scene.orientation);
  held.width = stored.width;
  held.height = stored.height;
  std::vector<uint8_t> jpeg =
      EncodeJpeg(stored.rgb, stored.width, stored.height, 3, scene.jpeg_quality);
  if (!scene.has_exif) return jpeg;
  const std::vector<uint8_t> exif = ExifSegment(held);
  jpeg.insert(jpeg.begin() + 2, exif.begin(), exif.end());
  return jpeg;
}

void WritePhotoFile(const PhotoScene& scene, const RgbImage& image, const std::string& path) {
  const std::vector<uint8_t> bytes = PhotoFile(scene, image);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
}

}  // namespace drape
