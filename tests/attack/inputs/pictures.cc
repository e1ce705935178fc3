// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/inputs/pictures.h"

#include <cstdio>
#include <cstdlib>

// After <cstdio>: jpeglib.h needs size_t and FILE.
#include <jpeglib.h>
#include <zlib.h>

#include <stdexcept>

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
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = static_cast<JDIMENSION>(form.width);
  info.image_height = static_cast<JDIMENSION>(form.height);
  info.input_components = 1;
  info.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, form.quality, TRUE);
  if (form.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  if (form.orientation != 0) {
    const std::string exif = MakeExif(form.orientation);
    jpeg_write_marker(&info, JPEG_APP0 + 1, reinterpret_cast<const JOCTET*>(exif.data()),
                      static_cast<unsigned>(exif.size()));
  }
  while (info.next_scanline < info.image_height) {
    auto* row = const_cast<uint8_t*>(&pixels[std::size_t(info.next_scanline) * form.width]);
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  std::string bytes(reinterpret_cast<char*>(buffer), size);
  jpeg_destroy_compress(&info);
  std::free(buffer);
  return bytes;
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
