// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/camera/camera.h"
#include "losses/metrics/observed_drape.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// How far two drapes are apart as they lie.
struct DrapeDistance {
  double mse = 0;  // of the coverages
  double iou = 0;
  double profile_rms = 0;        // [m]
  double outline_hausdorff = 0;  // [m]
};

// The motion of the second drape that brings its outline next to the first one's: mirrored
// (y → −y), when it says so, then turned counter-clockwise about the camera's centre [rad].
struct Alignment {
  double rotation = 0;  // in [−π, π]
  bool mirrored = false;
};

struct DrapeComparison {
  DrapeDistance raw;
  DrapeDistance aligned;  // after the alignment of the second image
  Alignment alignment;
};

// Both as the same camera sees them.
DrapeDistance ComputeDistance(const ObservedDrape& a, const ObservedDrape& b);

// The best of 360 rotations times two flips, least squares of the outlines, refined between them.
Alignment AlignDrapes(const ObservedDrape& a, const ObservedDrape& b);

DrapeComparison CompareDrapes(const ObservedDrape& a, const ObservedDrape& b, const Camera& camera);

// Symmetric Hausdorff distances of two surfaces to `tolerance` [m] (CGAL), the second one as it
// lies and after `alignment`. Throws InputError (prefix `where`) for a position that is not finite.
struct SurfaceDistance {
  double raw = 0;      // [m]
  double aligned = 0;  // [m]
};
SurfaceDistance CompareSurfaces(const ObjSurface& a, const ObjSurface& b,
                                const Alignment& alignment, const std::string& where,
                                double tolerance = 1e-4);

}  // namespace drape
