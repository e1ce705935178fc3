// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace drape::attack {

// Encoded pictures, good and bad.

inline constexpr int kStarSize = 256;  // px
// The grey pixels of a drape, shape [256, 256]; 0 is cloth.
std::vector<uint8_t> MakeStarPixels();

struct JpegForm {
  bool progressive = false;
  int quality = 95;
  int orientation = 0;  // EXIF; 0: no EXIF
  int width = kStarSize, height = kStarSize;
};
// The bytes of a grey JPEG.
std::string EncodeJpegAs(const std::vector<uint8_t>& pixels, const JpegForm& form);

}  // namespace drape::attack
