// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace drape {

struct ObstacleDistance;

// A solid bounded by a closed triangle mesh, such as a body at one time. Its distance is known up
// to `reach`, which has to be more than cloth can enter or come near between two times.
class SurfaceObstacle {
 public:
  // x: shape [3, V] [m]; triangles: counter-clockwise seen from outside, each edge in two of them.
  // before: of the vertices at the begin of the step, in whose course friction is reckoned; empty:
  // the solid does not move.
  SurfaceObstacle(Eigen::Matrix3Xd x, std::vector<std::array<int, 3>> triangles,
                  Eigen::Matrix3Xd before = {}, double reach = 0.03);

  // Outside: the smooth minimum −k·ln Σ exp(−d/k) of the distances d from the triangles, k = .3 mm,
  // without which cloth in a concave place would have no equilibrium. It is at most that of the
  // nearest point, by .2 mm over an edge and .5 mm over a corner less. Inside: that of the nearest
  // point, negative [Baerentzen 2005]. `reach` and no derivatives where no triangle is nearer. The
  // second derivatives are those of the minimum of planes, negative semidefinite [MODEL, M60]; of
  // the distances d they are left out: they are those of facets, not of the body.
  ObstacleDistance DistanceTo(const Eigen::Vector3d& x) const;
  const Eigen::Matrix3Xd& x() const { return x_; }
  // At the begin of the step [m].
  const Eigen::Matrix3Xd& before() const { return before_.cols() == 0 ? x_ : before_; }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  // How far the point nearest to x has moved in the step [m].
  Eigen::Vector3d Move(const Eigen::Vector3d& x) const;

 private:
  // The nearest point as weights of the three corners of a triangle; triangle −1: none in reach.
  struct Nearest {
    int triangle = -1;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  };
  Nearest FindNearest(const Eigen::Vector3d& x) const;
  std::span<const int> TrianglesNear(const Eigen::Vector3d& x) const;  // those of its cell
  Eigen::Vector3d Place(const Nearest& nearest) const;
  void FillGrid();
  void FindNormals();
  void FindBalls();
  // The cell of x, shape [3]; outside of the grid: negative or too large.
  Eigen::Vector3i Cell(const Eigen::Vector3d& x) const;
  // Of a nearest point by its weights: that of its triangle, edge or corner.
  Eigen::Vector3d PseudoNormal(const Nearest& nearest) const;

  Eigen::Matrix3Xd x_, before_;
  std::vector<std::array<int, 3>> triangles_;
  double reach_;
  Eigen::Matrix3Xd centre_;                       // of a ball around each triangle [m]
  Eigen::VectorXd radius_;                        // and its radius [m]
  Eigen::Matrix3Xd face_normal_, corner_normal_;  // of triangles; of vertices, by angle
  std::vector<std::array<int, 3>> neighbour_;     // of triangle t over the edge opposite corner k
  // Triangles within reach of each cell of a grid over the mesh.
  Eigen::Vector3d origin_;
  Eigen::Vector3i cells_;
  std::vector<int> cell_start_, cell_triangle_;
};

}  // namespace drape
