// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/camera/camera.h"
#include "losses/metrics/observed_drape.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// The distances of two drapes, without alignment [MODEL, M50].
struct DrapeDistance {
  double mse = 0;  // mean squared error of the coverages
  double iou = 0;
  double profile_rms = 0;        // [m]
  double outline_hausdorff = 0;  // [m]
};

// The motion of the second drape that best aligns its outline with the first outline: mirrored (y →
// −y) if `mirrored`, then turned counter-clockwise about the camera centre by `rotation` [rad].
struct Alignment {
  double rotation = 0;  // in [−π, π]
  bool mirrored = false;
};

struct DrapeComparison {
  DrapeDistance raw;
  DrapeDistance aligned;  // after the alignment of the second image
  Alignment alignment;
};

// Both drapes must be of the same discs and seen by the same camera.
DrapeDistance ComputeDistance(const ObservedDrape& a, const ObservedDrape& b);

// The best of 360 rotations times two flips by least squares of the outlines, refined between the
// angles.
Alignment AlignDrapes(const ObservedDrape& a, const ObservedDrape& b);

DrapeComparison CompareDrapes(const ObservedDrape& a, const ObservedDrape& b, const Camera& camera);

// The symmetric Hausdorff distances of two surfaces to within `tolerance` [m] (CGAL), with the
// second surface unmoved and after `alignment`. Throws InputError (prefix `where`) for a position
// that is not finite.
struct SurfaceDistance {
  double raw = 0;      // [m]
  double aligned = 0;  // [m]
};
SurfaceDistance CompareSurfaces(const ObjSurface& a, const ObjSurface& b,
                                const Alignment& alignment, const std::string& where,
                                double tolerance = 1e-4);

}  // namespace drape
