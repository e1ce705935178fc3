// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "losses/readout/readout.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Readouts of a measured cloud of points. Both are continuous in x but where a point is equally
// near to two places of the cloth.

// For each of N measured points p the vector p − q [m] from the closest place q of the cloth,
// K = 3N; 0 is measured. q slides as the cloth moves, which the derivative holds: it is exact
// where q is inside a face, an edge or a corner, at no distance too. Inside a face p − q has the
// normal's direction, so that N points on a cloth count as N numbers, not 3N. Read returns false
// when x is not finite or a face has no area.
class PointCloudReadout final : public Readout {
 public:
  // points [m], shape [3N]. `mesh` must outlive the object.
  PointCloudReadout(const Mesh& mesh, Eigen::VectorXd points);
  int size() const override { return static_cast<int>(points_.size()); }
  int group() const override { return 3; }
  int num_independent() const override { return size() / 3; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  const Mesh& mesh_;
  Eigen::VectorXd points_;
};

struct UncoveredOptions {
  // The distance between neighbouring points of the cloud [m], ≥ 0: cloth that is nearer than this
  // to one of them lies between them.
  double spacing = 0.0;
  // Cloth that is farther than this from all points [m] was not seen. It reads a constant.
  double max_distance = std::numeric_limits<double>::infinity();
};

// For each of M vertices of the cloth how far it is from the cloud, K = M; 0 is measured. With d
// the distance to the closest point [m] it is min(d, max_distance) − spacing, at least 0: it draws
// cloth to the cloud that PointCloudReadout, which asks only for cloth at each point, leaves
// outside. For a partial scan leave it out, or set max_distance: cloth farther off has a zero
// derivative, and its cost does not fall when it moves away. The derivative is exact but at the
// two bounds, where it jumps. Read returns false when x is not finite.
class UncoveredReadout final : public Readout {
 public:
  // points [m], shape [3N], N > 0. vertices: of the cloth, each less than V.
  UncoveredReadout(const Eigen::VectorXd& points, std::vector<int> vertices,
                   const UncoveredOptions& options);
  ~UncoveredReadout() override;
  int size() const override { return static_cast<int>(vertices_.size()); }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
  std::vector<int> vertices_;
  UncoveredOptions options_;
};

}  // namespace drape
