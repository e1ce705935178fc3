// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/projection.h"

namespace drape {

enum class ReadoutKind {
  kOutline,        // OutlineReadout
  kSoftSilhouette  // SilhouetteReadout
};

// The readout of one rollout as plain data, from which a device computes it.
struct DeviceReadout {
  ReadoutKind kind;
  int size;  // K
  Projection camera;
  int width, height;  // of the image [px]; K = height·width of a silhouette
  double half_width;  // of a silhouette's ramp [px]
};

}  // namespace drape
