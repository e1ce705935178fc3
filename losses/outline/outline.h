// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/outline_ray.h"
#include "physics/linalg/block_matrix.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Radial profile r(θ_k) [px] about the camera's centre, θ_k = 2πk/K, counter-clockwise as seen in
// the image (+column is θ = 0, up is θ = π/2).
struct Outline {
  Eigen::VectorXd radius;        // [px], shape [K]; 0 at a missing angle
  std::vector<OutlineHit> hits;  // shape [K] from a mesh, empty from an image
  std::vector<int> missing;      // indices k whose ray met no cloth

  int num_angles() const { return static_cast<int>(radius.size()); }
};

// Outermost 0.5 level of the coverage on each ray: bilinear samples every 0.25 px from outside
// inward, the crossing by linear interpolation. False when an angle is missing.
bool OutlineFromImage(const GrayImage& image, const Camera& camera, int num_angles,
                      Outline* outline);

// Outermost crossing of each ray with the projected hem (mesh.boundary_loops[0]) of positions x
// [m], shape [3V]. A fold that bulges over the hem does not count here; RenderSoft sees it. False
// when an angle is missing, a coordinate is not finite or a vertex of the hem is behind the camera
// (then all angles are missing).
bool OutlineFromMesh(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                     int num_angles, Outline* outline);

// The Jacobian J = ∂r/∂x [px/m], shape [K, 3V], of an outline of a mesh with V vertices.
Eigen::SparseMatrix<double, Eigen::RowMajor> OutlineJacobian(const Outline& outline,
                                                             int num_vertices);

// J · dx_dp: shape [3V, P] → [K, P].
RowMatrix OutlineJacobianTimes(const Outline& outline, const RowMatrix& dx_dp);

// Jᵀ as right-hand sides of an adjoint solve, shape [3V, K].
Eigen::MatrixXd OutlineAdjointSeeds(const Outline& outline, int num_vertices);

// gradient += Jᵀ · radius_adjoint: shapes [K] → [3V].
void AdjOutline(const Outline& outline, const Eigen::VectorXd& radius_adjoint,
                Eigen::VectorXd* gradient);

// Root mean square of a − b, in their unit; equal, non-zero sizes.
double ProfileRms(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

}  // namespace drape
