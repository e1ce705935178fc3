// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace drape {

// Coverage of cloth, 1 = cloth (black in a file), 0 = background (white); row 0 is the top.
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

// Decodes a JPEG or PNG, told apart by content: grey, RGB, RGBA (over white), palette, 8 or 16 bit;
// coverage = 1 − grey. An EXIF orientation is not applied: the pixels count as they are stored.
// InputError naming the path: missing, empty, truncated, not an image, more than 2^28 pixels.
GrayImage ReadImage(const std::string& path);

// InputError (prefix `where`): smaller than 16×16, a coverage outside [0, 1], no cloth, no
// background, cloth (coverage ≥ 0.5) at the border.
void CheckSilhouette(const GrayImage& image, const std::string& where);

// ReadImage, then CheckSilhouette.
GrayImage ReadSilhouette(const std::string& path);

// 1 where the coverage is at least `level`, else 0: at the default, what a hard-edged picture was
// before JPEG blurred it (grey < 128 is cloth). Most published silhouettes have grey edges, which
// this would spoil (mean squared change .0013).
GrayImage HardEdged(const GrayImage& image, float level = 0.5f);

// 8-bit PNG (silhouette: black cloth on white). Atomic: InputError naming the path when the folder
// or the disk refuses, and a file that was there before is untouched.
void WritePng(const GrayImage& image, const std::string& path);
void WritePng(const RgbImage& image, const std::string& path);

}  // namespace drape
