// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "losses/image/image_codec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

struct PngHandle {
  PngHandle() { png.version = PNG_IMAGE_VERSION; }
  ~PngHandle() { png_image_free(&png); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;
  png_image png = {};
};

InputError Broken(const std::string& where, const png_image& png) {
  return InputError(where, std::string("truncated or damaged PNG: ") + png.message);
}

void WriteBytes(const uint8_t* pixels, int width, int height, png_uint_32 format,
                const std::string& path) {
  PngHandle handle;
  handle.png.width = width;
  handle.png.height = height;
  handle.png.format = format;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(handle.png);
  std::string bytes(size, '\0');
  const bool encoded =
      png_image_write_to_memory(&handle.png, bytes.data(), &size, 0, pixels, 0, nullptr);
  CHECK(encoded) << handle.png.message;
  bytes.resize(size);
  WriteFileAtomically(path, bytes);
}

// All samples of a picture, converted to `format`, on white where it is transparent.
std::vector<uint8_t> ReadSamples(const std::vector<uint8_t>& bytes, png_uint_32 format,
                                 const std::string& where, png_image& png) {
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) throw Broken(where, png);
  CheckPixelCount(png.width, png.height, where);
  png.format = format;
  png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // otherwise libpng reads 16-bit samples as linear light
  const png_color white = {255, 255, 255};
  std::vector<uint8_t> samples(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, &white, samples.data(), 0, nullptr)) throw Broken(where, png);
  return samples;
}

}  // namespace

bool LooksLikePng(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= 8 && png_sig_cmp(bytes.data(), 0, 8) == 0;
}

GrayImage DecodePng(const std::vector<uint8_t>& bytes, const std::string& where) {
  PngHandle handle;
  const std::vector<uint8_t> gray = ReadSamples(bytes, PNG_FORMAT_GRAY, where, handle.png);
  GrayImage image(static_cast<int>(handle.png.width), static_cast<int>(handle.png.height));
  for (size_t i = 0; i < gray.size(); ++i) image.coverage[i] = CoverageFromGray(gray[i]);
  return image;
}

RgbImage DecodePngColors(const std::vector<uint8_t>& bytes, const std::string& where) {
  PngHandle handle;
  std::vector<uint8_t> rgb = ReadSamples(bytes, PNG_FORMAT_RGB, where, handle.png);
  return {static_cast<int>(handle.png.width), static_cast<int>(handle.png.height), std::move(rgb)};
}

void WritePng(const GrayImage& image, const std::string& path) {
  CHECK_EQ(image.coverage.size(), size_t(image.width) * image.height);
  std::vector<uint8_t> gray(image.coverage.size());
  for (size_t i = 0; i < gray.size(); ++i) {
    const float c = image.coverage[i];
    CHECK(c >= 0 && c <= 1) << "coverage " << c << " of pixel " << i;
    gray[i] = static_cast<uint8_t>(std::lround(255 * (1 - c)));
  }
  WriteBytes(gray.data(), image.width, image.height, PNG_FORMAT_GRAY, path);
}

void WritePng(const RgbImage& image, const std::string& path) {
  CHECK_EQ(image.rgb.size(), size_t(3) * image.width * image.height);
  WriteBytes(image.rgb.data(), image.width, image.height, PNG_FORMAT_RGB, path);
}

}  // namespace drape
