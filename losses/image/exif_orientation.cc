// SPDX-License-Identifier: Apache-2.0
#include "losses/image/exif_orientation.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace drape {
namespace {

constexpr int kUpright = 1;

// The TIFF structure of EXIF: unsigned numbers in the byte order that its header names.
class Tiff {
 public:
  explicit Tiff(std::span<const uint8_t> bytes)
      : bytes_(bytes), big_endian_(!bytes.empty() && bytes[0] == 'M') {}

  // The number of `size` bytes at `offset`; 0 where the data end before it.
  uint32_t At(size_t offset, size_t size) const {
    if (offset > bytes_.size() || size > bytes_.size() - offset) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i)
      value = value << 8 | bytes_[offset + (big_endian_ ? i : size - 1 - i)];
    return value;
  }

 private:
  std::span<const uint8_t> bytes_;
  bool big_endian_;
};

}  // namespace

int ReadExifOrientation(std::span<const uint8_t> app1) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr uint32_t kTiffMark = 42, kOrientationTag = 0x0112;
  constexpr size_t kEntrySize = 12;
  if (app1.size() < kExif.size() || !std::equal(kExif.begin(), kExif.end(), app1.begin()))
    return kUpright;
  const Tiff tiff(app1.subspan(kExif.size()));
  if (tiff.At(2, 2) != kTiffMark) return kUpright;
  const size_t directory = tiff.At(4, 4);
  const uint32_t entries = tiff.At(directory, 2);
  for (uint32_t i = 0; i < entries; ++i) {
    const size_t entry = directory + 2 + kEntrySize * i;
    if (tiff.At(entry, 2) != kOrientationTag) continue;
    const uint32_t value = tiff.At(entry + 8, 2);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : kUpright;
  }
  return kUpright;
}

GrayImage Upright(GrayImage image, int orientation) {
  if (orientation == kUpright) return image;
  const bool exchanged = orientation >= 5;
  // Where the shown pixel is stored, after the exchange of rows and columns.
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  GrayImage shown(exchanged ? image.height : image.width, exchanged ? image.width : image.height);
  for (int row = 0; row < shown.height; ++row) {
    for (int col = 0; col < shown.width; ++col) {
      int c = exchanged ? row : col, r = exchanged ? col : row;
      if (from_right) c = image.width - 1 - c;
      if (from_bottom) r = image.height - 1 - r;
      shown.at(col, row) = image.at(c, r);
    }
  }
  return shown;
}

}  // namespace drape
