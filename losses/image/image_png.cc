// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>
#include <png.h>
#include <zlib.h>

#include <algorithm>
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

constexpr std::size_t kSignatureSize = 8, kHeaderSize = 25;  // of a file, of its first chunk
constexpr std::size_t kFrameSize = 12;                       // of a chunk beside its content
const std::string kTextChunk = "tEXt", kKeyword = std::string("Comment") + '\0';

std::string BigEndian(uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  return bytes;
}

// The chunk of a comment [PNG, 11.3.4.3].
std::string TextChunk(const std::string& comment) {
  const std::string content = kKeyword + comment, typed = kTextChunk + content;
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(typed.data()), uInt(typed.size()));
  return BigEndian(uint32_t(content.size())) + typed + BigEndian(uint32_t(sum));
}

// comment: empty: none.
void WriteBytes(const uint8_t* pixels, int width, int height, png_uint_32 format,
                const std::string& path, const std::string& comment) {
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
  if (!comment.empty()) bytes.insert(kSignatureSize + kHeaderSize, TextChunk(comment));
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

std::optional<DrapeDiscs> ReadPngDiscs(const std::string& path) {
  const std::string bytes = ReadWholeFile(path);
  if (!LooksLikePng({bytes.begin(), bytes.begin() + std::min(bytes.size(), kSignatureSize)}))
    return std::nullopt;
  for (std::size_t at = kSignatureSize; at + kFrameSize <= bytes.size();) {
    const std::size_t size = png_get_uint_32(reinterpret_cast<png_const_bytep>(&bytes[at]));
    const std::string type = bytes.substr(at + 4, 4);
    if (type == "IDAT" || size > bytes.size() - at - kFrameSize) break;
    const std::string content = bytes.substr(at + 8, size);
    if (type == kTextChunk && content.starts_with(kKeyword)) {
      if (const auto discs = ParseDiscsLine(content.substr(kKeyword.size()))) return discs;
    }
    at += size + kFrameSize;
  }
  return std::nullopt;
}

void WritePng(const GrayImage& image, const std::string& path,
              const std::optional<DrapeDiscs>& discs) {
  CHECK_EQ(image.coverage.size(), size_t(image.width) * image.height);
  std::vector<uint8_t> gray(image.coverage.size());
  for (size_t i = 0; i < gray.size(); ++i) {
    const float c = image.coverage[i];
    CHECK(c >= 0 && c <= 1) << "coverage " << c << " of pixel " << i;
    gray[i] = static_cast<uint8_t>(std::lround(255 * (1 - c)));
  }
  WriteBytes(gray.data(), image.width, image.height, PNG_FORMAT_GRAY, path,
             discs ? DiscsLine(*discs) : "");
}

void WritePng(const RgbImage& image, const std::string& path) {
  CHECK_EQ(image.rgb.size(), size_t(3) * image.width * image.height);
  WriteBytes(image.rgb.data(), image.width, image.height, PNG_FORMAT_RGB, path, "");
}

}  // namespace drape
