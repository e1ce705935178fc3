// SPDX-License-Identifier: Apache-2.0
#pragma once

// jpeglib.h needs size_t and FILE.
// clang-format off
#include <cstdio>
#include <jpeglib.h>
// clang-format on
#include <png.h>

#include <cstdint>
#include <cstdlib>
#include <vector>

namespace drape {

// Encoders of small test files in formats that the library does not write.

// format is PNG_FORMAT_*; with PNG_FORMAT_FLAG_COLORMAP pixels are indices and `palette` holds the
// entries.
inline std::vector<uint8_t> EncodePng(const void* pixels, int width, int height, png_uint_32 format,
                                      const std::vector<uint8_t>& palette = {}, int entries = 0) {
  png_image png = {};
  png.version = PNG_IMAGE_VERSION;
  png.width = width;
  png.height = height;
  png.format = format;
  png.colormap_entries = entries;
  const void* colors = entries ? palette.data() : nullptr;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png) + 4096;
  std::vector<uint8_t> bytes(size);
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, colors)) return {};
  bytes.resize(size);
  return bytes;
}

// pixels are row-major with interleaved channels: 1 grey, 3 RGB, 4 CMYK. quality is that of
// libjpeg, 1 … 100.
inline std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& pixels, int width, int height,
                                       int channels, int quality = 95, bool progressive = false) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = width;
  info.image_height = height;
  info.input_components = channels;
  info.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, quality, TRUE);
  if (progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = const_cast<uint8_t*>(&pixels[size_t(info.next_scanline) * width * channels]);
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  std::vector<uint8_t> bytes(buffer, buffer + size);
  jpeg_destroy_compress(&info);
  std::free(buffer);
  return bytes;
}

}  // namespace drape
