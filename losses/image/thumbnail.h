// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/image/image.h"

namespace drape {

// The bytes of a JPEG: the picture, made smaller by means of squares of pixels until no side is
// longer than `longest` [px].
std::string MakeThumbnail(const RgbImage& image, int longest);

}  // namespace drape
