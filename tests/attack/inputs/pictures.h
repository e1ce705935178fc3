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

// The bytes of a PNG, put together chunk by chunk, so that each can be wrong.
struct PngForm {
  uint32_t width = kStarSize, height = kStarSize;  // as the header says
  uint8_t depth = 8, colour = 0, interlace = 0;
  std::string chunks = {};  // between header and data
};
// rows: the unfiltered bytes of the rows.
std::string EncodePngAs(const std::string& rows, std::size_t bytes_per_row, const PngForm& form);
std::string MakePngChunk(const std::string& type, const std::string& data);
std::string Deflate(const std::string& data);

struct BadPicture {
  std::string name;
  std::string file;  // its name
  std::string content;
  bool refused = true;
};
std::vector<BadPicture> MakeDamagedPictures();     // wrong files
std::vector<BadPicture> MakeMisleadingPictures();  // right files that show no drape

}  // namespace drape::attack
