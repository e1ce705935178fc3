// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "losses/camera/camera.h"
#include "physics/mesh/disc.h"

namespace drape {

// The height z ≤ 0 [m] at which the hem of a drape hangs where it is r [m] from the axis: cloth
// hardly stretches, so the hem is about its free length L = specimen − support from the support's
// edge. The distance is L·(1 − 0.09·u·(1 − u)), u = (r − support)/L: the shortening by folds,
// fitted to 18 simulated drapes of nine fabrics (drape coefficients of .10 to .92), to 2 mm rms at
// most (4 % of L) at any r. Outside [support, specimen], r is taken as the nearer end.
double EstimatedHemHeight(double r, const DrapeDiscs& discs);

// The vertical projection of the outline that a camera sees: its radial profile [m] about the
// support's centre, at the angles of `radius_px` [px], shape [K], K ≥ 8. Of an orthographic camera
// it is MetresFromPixels. A pinhole shows a hem below the support too small; each point is moved to
// the estimated height of the hem there. For an eye at 1 m the drape coefficient of an exact
// outline is within 0.3 points of that of the drape; of rendered photographs within 1.1
// (PHOTOS.md).
Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs);

}  // namespace drape
