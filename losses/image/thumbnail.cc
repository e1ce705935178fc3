// SPDX-License-Identifier: Apache-2.0
#include "losses/image/thumbnail.h"

#include <algorithm>

#include "losses/image/image_codec.h"

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
  const std::vector<uint8_t> bytes = EncodeJpeg(small.rgb, small.width, small.height, 3, kQuality);
  return {bytes.begin(), bytes.end()};
}

}  // namespace drape
