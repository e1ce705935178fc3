// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "physics/mesh/mesh.h"

namespace drape {

// Smooth random fields on a flat cloth, Σ_j coefficient_j · sd_j · φ_j with normal coefficients.
// φ_j are eigenfunctions of the Laplacian with free edges, sd_j² the Matérn spectrum [Lindgren
// 2011]. They are found on one mesh and read at the points of another, so that
// coefficients mean the same on both.

// ∫∇φ·∇ψ by linear elements ("cotangent" weights) on the rest shape, shape [V, V], symmetric.
Eigen::SparseMatrix<double> LaplaceStiffness(const Mesh& mesh);

struct LaplaceModes {
  Eigen::VectorXd eigenvalues;  // ascending from 0 [1/m²], shape [count]
  Eigen::MatrixXd vectors;  // at the vertices, shape [V, count]: of mean square 1 over the cloth,
                            // orthogonal by area, first entry of largest magnitude positive
};

// The lowest modes of LaplaceStiffness against the lumped area. 1 ≤ count < V − 1; CHECKs that
// Spectra finds them.
LaplaceModes FindLaplaceModes(const Mesh& mesh, int count);

struct MaternOptions {
  double length = 0.03;  // correlation length ℓ [m]: correlation about 0.14 at a distance of 2ℓ
  double sigma = 0.5;    // standard deviation of the field, averaged over the cloth
};

// sd_j of each mode, shape [count]: sd² ∝ (2/ℓ² + eigenvalue)^−2, that is smoothness ν = 1 in the
// plane, with Σ sd² = sigma²: what the modes left out would have carried is given to those kept.
Eigen::VectorXd MaternDeviations(const Eigen::VectorXd& eigenvalues, const MaternOptions& options);

}  // namespace drape
