// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_view.h"

namespace drape {

struct ObstacleDistance;

// Which of the distances from the parts of a mesh its smooth minimum sums [MODEL, M60].
enum class SurfaceBlend {
  // All facets. Over an edge the distance is less by .2 mm, over a corner by up to .5 mm, also
  // where the facets are flat: for bodies, from which a skin keeps the vertices of a garment.
  kFacets,
  // Facets and corners less edges that are not sharply concave. What is flat or convex has its
  // distance to rounding; only where two places of the surface are equally near, as in a concave
  // edge, it is less.
  kPlaces
};

// A solid bounded by a closed triangle mesh, such as a body at one time. Its distance is known up
// to `reach`, which has to be more than cloth can enter or come near between two times.
class SurfaceObstacle {
 public:
  // x: shape [3, V] [m]; triangles: counter-clockwise seen from outside, each edge in two of them.
  // before: positions of the vertices at the start of the step, for friction during it; empty:
  // the solid does not move.
  SurfaceObstacle(Eigen::Matrix3Xd x, std::vector<std::array<int, 3>> triangles,
                  Eigen::Matrix3Xd before = {}, double reach = 0.03,
                  SurfaceBlend blend = SurfaceBlend::kFacets);

  // Outside: the smooth minimum of the distances from the parts of the mesh, k = .3 mm, without
  // which cloth in a concave place would have no equilibrium; with its derivatives, those of edges
  // and corners too. Inside: that of the nearest point, negative [Baerentzen 2005]. `reach` and no
  // derivatives where no triangle is nearer.
  ObstacleDistance DistanceTo(const Eigen::Vector3d& x) const;
  // Whether x is inside, however deep, by the winding number [Van Oosterom 1983]; takes all
  // triangles.
  bool Encloses(const Eigen::Vector3d& x) const;
  const Eigen::Matrix3Xd& x() const { return x_; }
  // Positions at the start of the step [m].
  const Eigen::Matrix3Xd& before() const { return before_.cols() == 0 ? x_ : before_; }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

  // How far the point nearest to x has moved in the step [m].
  Eigen::Vector3d Move(const Eigen::Vector3d& x) const;

  // A view of this object, which must outlive the view.
  SurfaceView view() const;
  // The lists behind the view.
  struct Lists {
    std::vector<std::array<int, 3>> neighbour;  // of triangle t over the edge opposite corner k
    std::vector<int> counted;
    std::vector<int> cell_start, cell_triangle;
  };
  const Lists& lists() const { return lists_; }

 private:
  void FindNormals();
  void FindBalls();
  bool IsSharplyConcave(int t, int k) const;
  void CountParts();
  bool IsConvex() const;
  void FillGrid();
  bool IsInReach(int t, const Eigen::Vector3i& cell) const;
  // The cell of x, shape [3]; outside of the grid: negative or too large.
  Eigen::Vector3i Cell(const Eigen::Vector3d& x) const;

  Eigen::Matrix3Xd x_, before_;
  std::vector<std::array<int, 3>> triangles_;
  double reach_;
  bool is_convex_ = false;
  Eigen::Matrix3Xd centre_;                       // of a ball around each triangle [m]
  Eigen::VectorXd radius_;                        // and its radius [m]
  Eigen::Matrix3Xd face_normal_, corner_normal_;  // of triangles; of vertices, by angle
  // A grid over the mesh.
  Eigen::Vector3d origin_;
  double cell_ = 0.0;  // [m]
  Eigen::Vector3i cells_;
  Lists lists_;
};

}  // namespace drape
