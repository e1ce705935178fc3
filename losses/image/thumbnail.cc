// SPDX-License-Identifier: Apache-2.0
#include "losses/image/thumbnail.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

// jpeglib.h needs size_t and FILE.
#include <jpeglib.h>

namespace drape {
namespace {

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

std::string MakeThumbnail(const RgbImage& image, int longest) {
  constexpr int kQuality = 80;
  const int square = (std::max(image.width, image.height) + longest - 1) / longest;
  const RgbImage small = Shrunk(image, std::min({square, image.width, image.height}));
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = small.width;
  info.image_height = small.height;
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, kQuality, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    auto* row = const_cast<uint8_t*>(&small.rgb[size_t(3) * info.next_scanline * small.width]);
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  std::string bytes(buffer, buffer + size);
  jpeg_destroy_compress(&info);
  std::free(buffer);
  return bytes;
}

}  // namespace drape
