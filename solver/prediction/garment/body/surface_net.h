// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

#include "physics/mesh/obj_io.h"

namespace drape {

// Where to look for a surface: x and y from −half to half, z from bottom to top [m].
struct SurfaceNetBox {
  double half_x, half_y, bottom, top;
};

// The zero of a smooth function, positive outside [m], as a closed mesh of triangles that are
// counter-clockwise as seen from outside: one vertex for each sheet of the surface in a cube of
// side `cell` [Gibson 1998], [Nielson 2004], then relaxed along the surface with edges flipped to
// the Delaunay criterion. Mean edge 0.9 cells. The mesh of a function that is even in x is
// symmetric, to rounding. CHECKs that the box contains the surface.
ObjSurface MakeSurfaceNet(const std::function<double(const Eigen::Vector3d&)>& distance,
                          const SurfaceNetBox& box, double cell);

}  // namespace drape
