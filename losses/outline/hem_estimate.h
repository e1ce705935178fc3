// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

#include "losses/camera/camera.h"
#include "physics/mesh/disc.h"

namespace drape {

// The height z ≤ 0 [m] at which the hem of a drape hangs where it is r [m] from the axis: cloth
// hardly stretches, so the hem is about its free length L = specimen − support from the support's
// edge. The distance is L·(1 − 0.09·u·(1 − u)), u = (r − support)/L: the shortening by folds,
// fitted to 18 simulated drapes of nine fabrics (drape coefficients of .10 to .92), to 2 mm rms at
// most (4 % of L) at any r. Outside [support, specimen], r is taken as the nearer end.
double EstimatedHemHeight(double r, const DrapeDiscs& discs);

// Where the cloth ends, seen from above, at a point of the outline in a picture [m]. point_at(z):
// the point of the plane at height z that is seen there. Far from the support that is the hem, by
// iteration of its height. Near its rim it is the hem, or the cloth's bend over the rim, which
// hides a hem that is up to 6 % farther out, and the mean of both is reported: of 8 simulated
// drapes (finer and others than those of PHOTOS.md), a fifth are hems up to 1.02 radii of the
// support, all from 1.065 on.
Eigen::Vector2d EstimatedOutermost(const std::function<Eigen::Vector2d(double)>& point_at,
                                   const DrapeDiscs& discs);

// The vertical projection of the outline that a camera sees: its radial profile [m] about the
// support's centre, at the angles of `radius_px` [px], shape [K], K ≥ 8. Of an orthographic camera
// it is MetresFromPixels. A pinhole shows a hem below the support too small; each point is moved to
// the estimated height of the hem there (EstimatedOutermost). For an eye at 1 m the drape
// coefficient of an exact outline is within 0.4 points of that of the drape.
Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs);

}  // namespace drape
