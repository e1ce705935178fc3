// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "physics/mesh/disc.h"

namespace drape {

// An image of the coverage by cloth, 1 = cloth (black in a file), 0 = background (white); row 0 is
// the top.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<float> coverage;  // row-major, shape [height, width], in [0, 1]

  GrayImage() = default;
  GrayImage(int image_width, int image_height, float value = 0)
      : width(image_width), height(image_height), coverage(size_t(width) * height, value) {}

  float& at(int column, int row) { return coverage[size_t(row) * width + column]; }
  float at(int column, int row) const { return coverage[size_t(row) * width + column]; }
};

struct RgbImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgb;  // row-major, shape [height, width, 3]
};

// Decodes a JPEG or PNG, which are distinguished by their content: grey, RGB, RGBA (over white),
// palette, 8 or 16 bit; coverage = 1 − grey. A picture is turned and reflected as the orientation
// in its EXIF data says (eXIf chunk of a PNG). Throws InputError, naming the path, when the file is
// missing, empty, truncated, not an image, or, before it is decoded, for more than 2^26 pixels.
GrayImage ReadImage(const std::string& path);

// What a camera has written into its picture.
struct ExifData {
  int orientation = 1;    // 1 … 8; the picture has been turned accordingly
  double focal_35mm = 0;  // focal length of a 35-mm camera with the same view [mm]; 0: unknown
  int width = 0;          // of the picture as it was taken, before it was turned [px]; 0: unknown
  int height = 0;
  double density = 0;  // dots in a metre, of the programs that write it [px/m]; 0: unknown
};

struct Photograph {
  RgbImage image;  // upright
  ExifData exif;
};

// Reads an image in colour, with what EXIF says about the camera.
Photograph ReadPhotograph(const std::string& path);

// The dots a metre that a file states [px/m]: pHYs of a PNG; of a JPEG the density of JFIF, else
// the resolution of EXIF. Throws InputError where it states none, or two that differ. Notes 72 and
// 96 an inch, which programs write that know none.
double ReadPixelsPerMetre(const std::string& path);

// Writes an 8-bit PNG (a silhouette as black cloth on white). If `discs` are given, a comment in
// the file names them. The write is atomic: throws InputError, naming the path, when the folder or
// the disk does not allow it, and a file that existed before is then unchanged.
void WritePng(const GrayImage& image, const std::string& path,
              const std::optional<DrapeDiscs>& discs = {});
void WritePng(const RgbImage& image, const std::string& path);
// Reads the discs from that comment; none if the file is no PNG or has no such comment. Throws
// InputError for a file that cannot be read.
std::optional<DrapeDiscs> ReadPngDiscs(const std::string& path);

}  // namespace drape
