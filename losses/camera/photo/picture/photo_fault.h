// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/options/enum_names.h"

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
  kNotADrape
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
                                {PhotoFault::kNotADrape, "not a drape"}});
}

}  // namespace drape
