// SPDX-License-Identifier: Apache-2.0
#include "losses/image/exif.h"

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

// The values of a directory's entries that are short or long numbers.
class Directory {
 public:
  Directory(const Tiff& tiff, size_t offset) : tiff_(tiff), offset_(offset) {}

  // 0 where there is no such tag.
  uint32_t Value(uint32_t tag) const {
    constexpr uint32_t kShort = 3;
    constexpr size_t kEntrySize = 12;
    const uint32_t entries = tiff_.At(offset_, 2);
    for (uint32_t i = 0; i < entries; ++i) {
      const size_t entry = offset_ + 2 + kEntrySize * i;
      if (tiff_.At(entry, 2) != tag) continue;
      return tiff_.At(entry + 8, tiff_.At(entry + 2, 2) == kShort ? 2 : 4);
    }
    return 0;
  }

 private:
  const Tiff& tiff_;
  size_t offset_;
};

// Where the pixel that is shown at a column and row is stored.
struct StoredPlace {
  int column, row;
};
StoredPlace FindPlace(int orientation, int width, int height, int col, int row) {
  const bool exchanged = orientation >= 5;
  const bool from_right =
      orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom =
      orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  StoredPlace place{exchanged ? row : col, exchanged ? col : row};
  if (from_right) place.column = width - 1 - place.column;
  if (from_bottom) place.row = height - 1 - place.row;
  return place;
}

}  // namespace

ExifData ReadExif(std::span<const uint8_t> app1) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr uint32_t kTiffMark = 42;
  constexpr uint32_t kOrientation = 0x0112, kExifDirectory = 0x8769;
  constexpr uint32_t kFocalLengthIn35mm = 0xA405, kPixelWidth = 0xA002, kPixelHeight = 0xA003;
  constexpr uint32_t kMostPixels = 1 << 20;
  ExifData exif;
  if (app1.size() < kExif.size() || !std::equal(kExif.begin(), kExif.end(), app1.begin()))
    return exif;
  const Tiff tiff(app1.subspan(kExif.size()));
  if (tiff.At(2, 2) != kTiffMark) return exif;
  const Directory first(tiff, tiff.At(4, 4));
  const uint32_t orientation = first.Value(kOrientation);
  if (orientation >= 1 && orientation <= 8) exif.orientation = static_cast<int>(orientation);
  const uint32_t offset = first.Value(kExifDirectory);
  if (offset == 0) return exif;
  const Directory second(tiff, offset);
  exif.focal_35mm = second.Value(kFocalLengthIn35mm);
  exif.width = static_cast<int>(std::min(second.Value(kPixelWidth), kMostPixels));
  exif.height = static_cast<int>(std::min(second.Value(kPixelHeight), kMostPixels));
  return exif;
}

GrayImage Upright(GrayImage image, int orientation) {
  if (orientation == kUpright) return image;
  const bool exchanged = orientation >= 5;
  GrayImage shown(exchanged ? image.height : image.width, exchanged ? image.width : image.height);
  for (int row = 0; row < shown.height; ++row) {
    for (int col = 0; col < shown.width; ++col) {
      const StoredPlace place = FindPlace(orientation, image.width, image.height, col, row);
      shown.at(col, row) = image.at(place.column, place.row);
    }
  }
  return shown;
}

RgbImage Upright(RgbImage image, int orientation) {
  if (orientation == kUpright) return image;
  const bool exchanged = orientation >= 5;
  RgbImage shown{exchanged ? image.height : image.width, exchanged ? image.width : image.height,
                 std::vector<uint8_t>(image.rgb.size())};
  for (int row = 0; row < shown.height; ++row) {
    for (int col = 0; col < shown.width; ++col) {
      const StoredPlace place = FindPlace(orientation, image.width, image.height, col, row);
      std::copy_n(&image.rgb[3 * (size_t(place.row) * image.width + place.column)], 3,
                  &shown.rgb[3 * (size_t(row) * shown.width + col)]);
    }
  }
  return shown;
}

}  // namespace drape
