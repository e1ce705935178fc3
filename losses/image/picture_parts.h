// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

// The connected parts of a picture of two levels.
namespace drape {

// Row-major, shape [height, width], 1 = cloth.
struct PictureMask {
  int width = 0, height = 0;
  std::vector<uint8_t> value;

  uint8_t at(int column, int row) const { return value[size_t(row) * width + column]; }
};

struct PicturePart {
  int64_t pixels = 0;
  double column = 0, row = 0;  // of its centroid
  bool touches_border = false;
};

int64_t CountPixels(const std::vector<PicturePart>& parts);

// Pixels of one part that follow one another in a row: [first, end).
struct PixelRun {
  int row, first, end, part;
};

struct PictureParts {
  std::vector<PicturePart> parts;
  std::vector<PixelRun> runs;  // by row, then column
};

enum class Neighbours { kFour, kEight };

// The connected parts of the pixels of that value. Dark parts should be connected through corners
// (kEight) and their complement not (kFour), so that a closed curve has an inside. Throws
// InputError (prefix `where`) for more than 2^21 runs: such a picture is noise.
PictureParts FindParts(const PictureMask& mask, uint8_t value, Neighbours neighbours,
                       const std::string& where);

}  // namespace drape
