// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/losses/photo/rendered/rendered_photo.h"

namespace drape {

// The file that a telephone would write of a picture: turned as it was held, with EXIF data.
std::vector<uint8_t> PhotoFile(const PhotoScene& scene, const RgbImage& image);

// Writes it.
void WritePhotoFile(const PhotoScene& scene, const RgbImage& image, const std::string& path);

}  // namespace drape
