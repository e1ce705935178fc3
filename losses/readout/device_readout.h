// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "losses/camera/projection.h"

namespace drape {

enum class ReadoutKind {
  kOutline,        // OutlineReadout
  kSoftSilhouette  // SilhouetteReadout
};

// A readout of one rollout as plain data, with which a device reads it by itself.
struct DeviceReadout {
  ReadoutKind kind;
  int size;  // K
  Projection camera;
  int width, height;  // of the image [px]; K = height·width of a silhouette
  double half_width;  // of a silhouette's ramp [px]
};

}  // namespace drape
