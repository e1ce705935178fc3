// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// The symmetric Hausdorff distance of two closed polygons (their curves, not their areas), shape
// [2, N] and [2, M], in the unit of the points. It is taken over all points of the curves, not only
// the vertices, and is exact to `tolerance`.
double HausdorffOfPolygons(const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b,
                           double tolerance = 1e-7);

// The symmetric Hausdorff distance [m] of two triangle surfaces at positions x [m], shape [3V], to
// within `tolerance` [m] (CGAL). Throws InputError (prefix `where`) when a coordinate is not
// finite.
double HausdorffOfMeshes(const Mesh& mesh_a, const Eigen::VectorXd& x_a, const Mesh& mesh_b,
                         const Eigen::VectorXd& x_b, const std::string& where,
                         double tolerance = 1e-4);

// The distance of any two sets of triangles. They are cut apart where they are no manifold;
// triangles of zero area and vertices without a triangle are ignored. Throws InputError also when
// nothing is left.
double HausdorffOfSurfaces(const ObjSurface& a, const ObjSurface& b, const std::string& where,
                           double tolerance = 1e-4);

}  // namespace drape
