// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "physics/mesh/mesh.h"

namespace drape {

// Fields of one mesh read at the points of another, by their places in the flat cloth.

// Gradients of the three barycentric coordinates of a face [1/m], columns.
Eigen::Matrix<double, 2, 3> BarycentricGradients(const Mesh& mesh, const Face& face);

// A field outside the cloth, where another mesh of its outer boundary extends further.
enum class Extrapolation {
  kNearest,  // as at the edge of the nearest triangle: no weight is negative
  kLinear    // from the nearest triangle: exact for a linear field
};

// Rows of weights that read a field of the vertices of `mesh` at points, shape [2, N], in its plane
// (uv) [m]: linear in the triangle that holds the point, of the nearest one for a point outside.
// Shape [N, V].
Eigen::SparseMatrix<double, Eigen::RowMajor> InterpolationWeights(
    const Mesh& mesh, const Eigen::Matrix2Xd& points,
    Extrapolation beyond = Extrapolation::kNearest);

// Positions [m] of one mesh, shape [3V], read at points of the cloth by weights [N, V]
// (InterpolationWeights): shape [3N].
Eigen::VectorXd ReadPositions(const Eigen::SparseMatrix<double, Eigen::RowMajor>& weights,
                              const Eigen::VectorXd& x);

}  // namespace drape
