// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "losses/image/image.h"

namespace drape {

// A connected part of a picture of two levels.
struct PicturePart {
  int64_t pixels = 0;
  double column = 0, row = 0;  // of its centroid
  bool touches_border = false;
};

int64_t CountPixels(const std::vector<PicturePart>& parts);

// What was done to a picture to make the silhouette of one piece of cloth of it.
struct Segmentation {
  double background = 0.0, cloth = 1.0;  // mean coverage of the light and the dark pixels
  bool rescaled = false;            // background → 0, cloth → 1: the picture is a photograph
  std::vector<PicturePart> cut;     // dark parts outside the cloth, now background, largest first
  std::vector<PicturePart> filled;  // light parts inside the cloth, now cloth, largest first

  // One sentence for each thing that was done; none for a picture that was used as it is.
  std::vector<std::string> Notes() const;
};

struct Silhouette {
  GrayImage image;
  Segmentation segmentation;
};

// Makes the silhouette of the cloth in a picture. The two levels are those of Otsu's threshold
// [Otsu 1979]; where they are within kLevelTolerance of 0 and 1, the threshold is 0.5 and the
// coverage stays as it is, as in all published images. The cloth is the dark part nearest to the
// image's centre among those that are not small beside the largest one. Others are cut and holes
// are filled. After any of this, only pixels near the cloth's edge keep an intermediate coverage.
// Throws InputError (prefix `where`) for what is no silhouette of one piece of cloth: fewer than
// 16×16 pixels, a coverage outside [0, 1], no contrast, cloth at the border, a second part of half
// the cloth's size, holes of a tenth of it, or more than kMaxParts parts (noise).
inline constexpr double kLevelTolerance = 0.1;
inline constexpr int kMaxParts = 1000;
Silhouette SegmentSilhouette(GrayImage picture, const std::string& where);

// ReadImage, then SegmentSilhouette; throws as they do.
Silhouette ReadSilhouette(const std::string& path);

}  // namespace drape
