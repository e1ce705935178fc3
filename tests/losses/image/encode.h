// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <png.h>
#include <turbojpeg.h>

#include <cstdint>
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

// pixels are row-major with interleaved channels: 1 grey, 3 RGB, 4 CMYK. quality: 1 … 100.
inline std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& pixels, int width, int height,
                                       int channels, int quality = 95, bool progressive = false) {
  const tjhandle encoder = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  tjCompress2(encoder, pixels.data(), width, 0, height,
              channels == 1   ? TJPF_GRAY
              : channels == 3 ? TJPF_RGB
                              : TJPF_CMYK,
              &buffer, &size, channels == 1 ? TJSAMP_GRAY : TJSAMP_420, quality,
              TJFLAG_ACCURATEDCT | (progressive ? TJFLAG_PROGRESSIVE : 0));
  const std::vector<uint8_t> bytes(buffer, buffer + size);
  tjFree(buffer);
  tjDestroy(encoder);
  return bytes;
}

}  // namespace drape
