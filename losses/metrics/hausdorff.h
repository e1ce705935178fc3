// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/mesh/obj_io.h"

namespace drape {

// The symmetric Hausdorff distance of two closed polygons (their curves, not their areas), shape
// [2, N] and [2, M], in the unit of the points. It is taken over all points of the curves, not only
// the vertices, and is exact to `tolerance`.
double HausdorffOfPolygons(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b,
                           double tolerance = 1e-7);

// The symmetric Hausdorff distance [m] of two sets of triangles, to within `tolerance` [m] (CGAL).
// The sets are cut apart where they are no manifold; triangles of zero area and vertices without a
// triangle are ignored. Throws InputError (prefix `where`) when a coordinate is not finite and when
// nothing is left.
double HausdorffOfSurfaces(const ObjSurface& a, const ObjSurface& b, const std::string& where,
                           double tolerance = 1e-4);

}  // namespace drape
