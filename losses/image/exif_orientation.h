// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "losses/image/image.h"

// Internal to losses/: how a camera was held.
namespace drape {

// The orientation 1 … 8 in the payload of a JPEG's APP1 segment ("Exif", then a TIFF header), from
// tag 0x0112 of its first directory. 1, the upright one, where the payload is not EXIF, is damaged
// or does not say.
int ReadExifOrientation(std::span<const uint8_t> app1);

// The image as it is to be shown: reflected, turned, or both. 1 … 4 keep width and height, 5 … 8
// exchange them.
GrayImage Upright(GrayImage image, int orientation);

}  // namespace drape
