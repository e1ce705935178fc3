// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <png.h>

#include <cstdint>
#include <vector>

#include "losses/image/image_codec.h"

namespace drape {

// Of small test files in formats that the library itself does not write; EncodeJpeg is its own.

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

}  // namespace drape
