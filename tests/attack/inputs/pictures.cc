// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/pictures.h"

#include <zlib.h>

#include <stdexcept>

#include "tests/losses/image/encode.h"
#include "tests/losses/image/photograph.h"

namespace drape::attack {
namespace {

// A block APP1 with one entry, the orientation, in big-endian order.
std::string MakeExif(int orientation) {
  std::string block("Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01", 24);
  block += '\0';
  block += static_cast<char>(orientation);
  return block + std::string("\0\0\0\0\0\0", 6);
}

std::string BigEndian(uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}

}  // namespace

std::vector<uint8_t> MakeStarPixels() {
  const GrayImage star = StarSilhouette(Camera());
  std::vector<uint8_t> pixels;
  for (const float coverage : star.coverage)
    pixels.push_back(static_cast<uint8_t>(255 - static_cast<int>(255 * coverage)));
  return pixels;
}

std::string EncodeJpegAs(const std::vector<uint8_t>& pixels, const JpegForm& form) {
  const std::vector<uint8_t> jpeg =
      EncodeJpeg(pixels, form.width, form.height, 1, form.quality, form.progressive);
  std::string bytes(jpeg.begin(), jpeg.end());
  if (form.orientation == 0) return bytes;
  const std::string exif = MakeExif(form.orientation);
  const std::string size = BigEndian(static_cast<uint32_t>(exif.size() + 2)).substr(2);
  return bytes.insert(2, "\xff\xe1" + size + exif);  // after the mark of the image's start
}

std::string Deflate(const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                reinterpret_cast<const Bytef*>(data.data()), data.size(), 9) != Z_OK)
    throw std::runtime_error("cannot compress");
  packed.resize(size);
  return packed;
}

std::string MakePngChunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto checksum = static_cast<uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
  return BigEndian(static_cast<uint32_t>(data.size())) + body + BigEndian(checksum);
}

std::string EncodePngAs(const std::string& rows, std::size_t bytes_per_row, const PngForm& form) {
  std::string filtered;
  for (std::size_t at = 0; at < rows.size(); at += bytes_per_row)
    filtered += '\0' + rows.substr(at, bytes_per_row);
  std::string header = BigEndian(form.width) + BigEndian(form.height);
  for (const uint8_t byte : {form.depth, form.colour, uint8_t{0}, uint8_t{0}, form.interlace})
    header += static_cast<char>(byte);
  return "\x89PNG\r\n\x1a\n" + MakePngChunk("IHDR", header) + form.chunks +
         MakePngChunk("IDAT", Deflate(filtered)) + MakePngChunk("IEND", "");
}

}  // namespace drape::attack
