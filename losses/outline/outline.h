// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/outline_ray.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/mesh/mesh.h"

namespace drape {

// The radial profile r(θ_k) [px] about the camera centre, θ_k = 2πk/K, counter-clockwise as seen in
// the image (θ = 0 is +column, θ = π/2 is up) [MODEL, M47].
struct Outline {
  Eigen::VectorXd radius;        // [px], shape [K]; 0 at a missing angle
  std::vector<OutlineHit> hits;  // shape [K] from a mesh, empty from an image
  std::vector<int> missing;      // indices k of rays that met no cloth

  int num_angles() const { return static_cast<int>(radius.size()); }
};

// The outermost 0.5 level of the coverage on each ray: bilinear samples every 0.25 px from outside
// inwards, with the crossing by linear interpolation. Returns false when an angle is missing.
bool OutlineFromImage(const GrayImage& image, const Camera& camera, int num_angles,
                      Outline* outline);

// The distance from the camera's centre at which the coverage first falls below 0.5 along a ray, by
// samples every 0.25 px [px]; 0 when the centre is not on the cloth.
double FirstExit(const GrayImage& image, const Camera& camera, const Vec2& direction);

// The outermost crossing of each ray with the projected hem (mesh.boundary_loops[0]) of positions x
// [m], shape [3V]. A fold that bulges over the hem is not seen here, only by RenderSoft. Returns
// false when an angle is missing, and with all angles missing when a coordinate is not finite or a
// vertex of the hem is behind the camera.
bool OutlineFromMesh(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                     int num_angles, Outline* outline);

// The Jacobian J = ∂r/∂x [px/m], shape [K, 3V], of an outline of a mesh with V vertices
// [MODEL, M47].
Eigen::SparseMatrix<double, Eigen::RowMajor> OutlineJacobian(const Outline& outline,
                                                             int num_vertices);

// J · dx_dp: shape [3V, P] → [K, P]. CHECKs that the outline comes from a mesh.
RowMatrix OutlineJacobianTimes(const Outline& outline, const RowMatrix& dx_dp);

// Jᵀ as the right-hand sides of an adjoint solve, shape [3V, K].
Eigen::MatrixXd OutlineAdjointSeeds(const Outline& outline, int num_vertices);

// gradient += Jᵀ · radius_adjoint: shapes [K] → [3V].
void AdjOutline(const Outline& outline, const Eigen::VectorXd& radius_adjoint,
                Eigen::VectorXd* gradient);

// The root mean square of a − b, in their unit. Both have the same non-zero size.
double ProfileRms(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

}  // namespace drape
