// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

// One drape of a contact sheet.
struct SheetTile {
  const GrayImage* silhouette = nullptr;  // of the camera's size
  int group = 0;                          // drapes of one group have one colour
};

// Silhouettes side by side at half their size, in the colours of their groups, the support as a
// ring of that radius [m]. A bar under the tiles joins neighbours of one group. Without tiles: an
// empty place.
RgbImage RenderContactSheet(const std::vector<SheetTile>& tiles, const Camera& camera,
                            double support);

}  // namespace drape
