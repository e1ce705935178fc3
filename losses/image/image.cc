// SPDX-License-Identifier: Apache-2.0
#include "losses/image/image.h"

#include <glog/logging.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "losses/image/image_codec.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kMinSide = 16;  // [px]
constexpr float kClothLevel = 0.5f;

std::vector<uint8_t> ReadBytes(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(path, "is a folder, expected a JPEG or PNG file");
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path, std::string("cannot be read: ") + std::strerror(errno));
  std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw InputError(path, "reading failed before the end of the file");
  if (bytes.empty()) throw InputError(path, "is empty, expected a JPEG or PNG file");
  return bytes;
}

bool IsCloth(float coverage) { return coverage >= kClothLevel; }

bool TouchesBorder(const GrayImage& image) {
  for (int col = 0; col < image.width; ++col) {
    if (IsCloth(image.at(col, 0)) || IsCloth(image.at(col, image.height - 1))) return true;
  }
  for (int row = 0; row < image.height; ++row) {
    if (IsCloth(image.at(0, row)) || IsCloth(image.at(image.width - 1, row))) return true;
  }
  return false;
}

}  // namespace

void CheckPixelCount(int64_t width, int64_t height, const std::string& where) {
  if (width * height > kMaxPixels) {
    throw InputError(where, "image is " + std::to_string(width) + "x" + std::to_string(height) +
                                ", expected at most 2^28 pixels");
  }
}

GrayImage ReadImage(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadBytes(path);
  if (LooksLikeJpeg(bytes)) return DecodeJpeg(bytes, path);
  if (LooksLikePng(bytes)) return DecodePng(bytes, path);
  throw InputError(path, "is neither JPEG nor PNG (by its first bytes)");
}

void CheckSilhouette(const GrayImage& image, const std::string& where) {
  CHECK_EQ(image.coverage.size(), size_t(image.width) * image.height);
  if (image.width < kMinSide || image.height < kMinSide) {
    throw InputError(where, "image is " + std::to_string(image.width) + "x" +
                                std::to_string(image.height) + ", expected at least 16x16 pixels");
  }
  const auto in_range = [](float c) { return c >= 0 && c <= 1; };
  if (!std::all_of(image.coverage.begin(), image.coverage.end(), in_range)) {
    throw InputError(where, "a pixel's coverage is not in [0, 1]");
  }
  const auto cloth = std::count_if(image.coverage.begin(), image.coverage.end(), IsCloth);
  if (cloth == 0)
    throw InputError(where,
                     "no cloth: no pixel is darker than half, expected black cloth on white");
  if (size_t(cloth) == image.coverage.size()) {
    throw InputError(where, "no background: all pixels are dark, expected black cloth on white");
  }
  if (TouchesBorder(image)) {
    throw InputError(where, "cloth touches the border, expected black cloth with white all around");
  }
}

GrayImage HardEdged(const GrayImage& image, float level) {
  GrayImage hard = image;
  for (float& coverage : hard.coverage) coverage = coverage >= level ? 1.0f : 0.0f;
  return hard;
}

GrayImage ReadSilhouette(const std::string& path) {
  GrayImage image = ReadImage(path);
  CheckSilhouette(image, path);
  return image;
}

}  // namespace drape
