// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "physics/util/options/field.h"

namespace drape {

// Why a photograph is refused.
enum class PhotoFault {
  kNone,
  kCroppedPhoto,
  kNoFocalLength,
  kDark,
  kNoCloth,
  kLowContrast,
  kUnevenGround,
  kCroppedCloth,
  kTwoSpecimens,
  kTooSmall,
  kGlare,
  kBlur,
  kNoDisc,
  kNoTag,
  kTilted,
  kTooClose,
  kWrongSize,
  kNotADrape,
  kOurs
};
constexpr auto EnumNames(PhotoFault) {
  return MakeNames<PhotoFault>({{PhotoFault::kNone, "none"},
                                {PhotoFault::kCroppedPhoto, "cropped photograph"},
                                {PhotoFault::kNoFocalLength, "no focal length"},
                                {PhotoFault::kDark, "too dark"},
                                {PhotoFault::kNoCloth, "no cloth"},
                                {PhotoFault::kLowContrast, "low contrast"},
                                {PhotoFault::kUnevenGround, "uneven ground"},
                                {PhotoFault::kCroppedCloth, "cropped cloth"},
                                {PhotoFault::kTwoSpecimens, "two specimens"},
                                {PhotoFault::kTooSmall, "too small"},
                                {PhotoFault::kGlare, "glare"},
                                {PhotoFault::kBlur, "blur"},
                                {PhotoFault::kNoDisc, "no disc"},
                                {PhotoFault::kNoTag, "no tag"},
                                {PhotoFault::kTilted, "tilted"},
                                {PhotoFault::kTooClose, "too close"},
                                {PhotoFault::kWrongSize, "wrong size"},
                                {PhotoFault::kNotADrape, "not a drape"},
                                {PhotoFault::kOurs, "fault of this program"}});
}

// A connected part of a picture of two levels.
struct PicturePart {
  int64_t pixels = 0;
  double column = 0, row = 0;  // of its centroid
  bool touches_border = false;
};

int64_t CountPixels(const std::vector<PicturePart>& parts);

// What was done to a picture to make the silhouette of one piece of cloth of it.
struct Segmentation {
  double background = 0.0, cloth = 1.0;  // mean coverage of ground and cloth
  bool photograph = false;               // the cloth was found by its colours
  double focal_35mm = 0.0;               // of a photograph, as its file tells it [mm]; 0: unknown
  std::vector<PicturePart> cut;     // dark parts outside the cloth, now background, largest first
  std::vector<PicturePart> filled;  // light parts inside the cloth, now cloth, largest first
  std::vector<std::string> seen;    // one sentence for anything else that a user should know
  std::vector<std::string> doubts;  // the same of what may make the outline wrong

  // One sentence for each thing that was done; none for a picture that was used as it is.
  std::vector<std::string> Notes() const;
};

struct Silhouette {
  GrayImage image;
  Segmentation segmentation;
};

// Returns whether nearly all pixels are black or white and the others lie along the edges between
// them, as in a silhouette of any size and in a mask.
bool IsSilhouette(const GrayImage& image);

// Makes the silhouette of the cloth in a picture. The coverage of a silhouette stays as it is
// where its two levels are within kLevelTolerance of 0 and 1, as in all published images; others
// are scaled; one that is white on black, with all of its border black, is inverted.
// The cloth is the dark part nearest to the image's centre among those that are not small beside
// the largest one. Others are cut and holes are filled. After any of this, only pixels near the
// cloth's edge keep an intermediate coverage. In any other picture the cloth is found by its
// colours, as drape_photo finds it (FindSilhouette). Throws InputError (prefix `where`) for what is
// no picture of one piece of cloth: fewer than 16×16 pixels, a coverage outside [0, 1], cloth at
// the border, a second part of half the cloth's size, holes of a tenth of it that are no round
// support, more than kMaxParts parts (noise), or a PhotoFault.
inline constexpr double kLevelTolerance = 0.1;
inline constexpr int kMaxParts = 1000;
Silhouette SegmentSilhouette(GrayImage picture, const std::string& where);

// Reads a file, and makes its silhouette; throws as ReadImage and SegmentSilhouette do.
Silhouette ReadSilhouette(const std::string& path);

// Reads a mask of a cloth that is seen from any side, so its parts and holes are the cloth's own.
// Levels are scaled and white on black is inverted, as by SegmentSilhouette. Throws as ReadImage
// does, and InputError for a picture with fewer than 16×16 pixels, or not of two levels.
GrayImage ReadMask(const std::string& path);

}  // namespace drape
