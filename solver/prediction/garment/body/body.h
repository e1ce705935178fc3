// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <utility>
#include <vector>

namespace drape {

// A moving body that wears a garment: a closed surface of triangles that stay the same while their
// vertices move. z is up, the body faces −y, and its left is +x.
class Body {
 public:
  virtual ~Body() = default;

  // Counter-clockwise as seen from outside.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  int num_vertices() const { return num_vertices_; }

  // Positions of the vertices [m], shape [3B], at time t ≥ 0 [s]. Continuous in t.
  virtual Eigen::VectorXd Positions(double t) const = 0;
  // The rigid motion of the pelvis since t = 0: where a point that moves with it has gone. For
  // waistbands and other rings that the body holds.
  virtual Eigen::Isometry3d PelvisMotion(double t) const = 0;

 protected:
  Body(std::vector<std::array<int, 3>> triangles, int num_vertices)
      : triangles_(std::move(triangles)), num_vertices_(num_vertices) {}

 private:
  std::vector<std::array<int, 3>> triangles_;
  int num_vertices_;
};

}  // namespace drape
