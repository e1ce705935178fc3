// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "losses/image/image.h"

// Internal to losses/: how a camera was held, and its lens.
namespace drape {

// What the payload of a JPEG's APP1 segment ("Exif", then a TIFF header) says: the orientation
// 1 … 8, tag 0x0112 of its first directory, and of its EXIF directory the focal length in 35-mm
// film (0xA405) and the size of the picture as it was taken (0xA002, 0xA003). The defaults where
// the payload is not EXIF, is damaged or does not say.
ExifData ReadExif(std::span<const uint8_t> app1);

// The image as it is to be shown: reflected, turned, or both. 1 … 4 keep width and height, 5 … 8
// exchange them.
GrayImage Upright(GrayImage image, int orientation);
RgbImage Upright(RgbImage image, int orientation);

}  // namespace drape
