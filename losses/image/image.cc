// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "losses/image/image_codec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

std::vector<uint8_t> ReadBytes(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(path, "is a folder, expected a JPEG or PNG file");
  }
  errno = 0;
  if (!std::ifstream(path, std::ios::binary))
    throw InputError(path, std::string("cannot be read: ") + std::strerror(errno));
  const std::string text = ReadWholeFile(path);
  std::vector<uint8_t> bytes(text.begin(), text.end());
  if (bytes.empty()) throw InputError(path, "is empty, expected a JPEG or PNG file");
  return bytes;
}

// What is left of a square at the right and lower border is left out.
RgbImage Shrunk(const RgbImage& image, int square) {
  RgbImage small{image.width / square, image.height / square, {}};
  for (int row = 0; row < small.height; ++row)
    for (int column = 0; column < small.width; ++column)
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int y = row * square; y < (row + 1) * square; ++y)
          for (int x = column * square; x < (column + 1) * square; ++x)
            sum += image.rgb[3 * (size_t(y) * image.width + x) + channel];
        small.rgb.push_back(static_cast<uint8_t>(sum / (square * square)));
      }
  return small;
}

}  // namespace

void CheckPixelCount(int64_t width, int64_t height, const std::string& where) {
  if (width * height > kMaxPixels) {
    throw InputError(where, "image is " + std::to_string(width) + "x" + std::to_string(height) +
                                ", expected at most 2^26 pixels (67 million)");
  }
}

GrayImage ReadImage(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadBytes(path);
  if (LooksLikeJpeg(bytes)) return DecodeJpeg(bytes, path);
  if (LooksLikePng(bytes)) return DecodePng(bytes, path);
  throw InputError(path, "is neither JPEG nor PNG (by its first bytes)");
}

Photograph ReadPhotograph(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadBytes(path);
  if (LooksLikeJpeg(bytes)) return DecodeJpegColors(bytes, path);
  if (LooksLikePng(bytes)) return {DecodePngColors(bytes, path), {}};
  throw InputError(path, "is neither JPEG nor PNG (by its first bytes)");
}

GrayImage HardEdged(const GrayImage& image, float level) {
  GrayImage hard = image;
  for (float& coverage : hard.coverage) coverage = coverage >= level ? 1.0f : 0.0f;
  return hard;
}

std::string MakeThumbnail(const RgbImage& image, int longest) {
  constexpr int kQuality = 80;
  const int square = (std::max(image.width, image.height) + longest - 1) / longest;
  const RgbImage small = Shrunk(image, std::min({square, image.width, image.height}));
  const std::vector<uint8_t> bytes = EncodeJpeg(small.rgb, small.width, small.height, 3, kQuality);
  return {bytes.begin(), bytes.end()};
}

}  // namespace drape
