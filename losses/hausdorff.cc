// SPDX-License-Identifier: Apache-2.0
#include "losses/hausdorff.h"

// distance.h of CGAL 5.5 does not compile before the kernel.
// clang-format off
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
// clang-format on
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "physics/errors.h"

namespace drape {
namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;

double DistanceToSegment(const Vector2d& p, const Matrix2Xd& polygon, int segment) {
  const Vector2d a = polygon.col(segment);
  const Vector2d e = polygon.col((segment + 1) % polygon.cols()) - a;
  const double length2 = e.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(e) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * e).norm();
}

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  int segment = -1;
};

Nearest FindNearest(const Vector2d& p, const Matrix2Xd& polygon) {
  Nearest nearest;
  for (int i = 0; i < polygon.cols(); ++i) {
    const double distance = DistanceToSegment(p, polygon, i);
    if (distance < nearest.distance) nearest = {distance, i};
  }
  return nearest;
}

struct Piece {
  Vector2d a, b;
  Nearest near_a, near_b;
};

// The distance to ONE segment of the target is convex along the piece, so its larger end value
// bounds the distance to the target on the whole piece.
double UpperBound(const Piece& piece, const Matrix2Xd& target) {
  const double by_a =
      std::max(piece.near_a.distance, DistanceToSegment(piece.b, target, piece.near_a.segment));
  const double by_b =
      std::max(piece.near_b.distance, DistanceToSegment(piece.a, target, piece.near_b.segment));
  return std::min(by_a, by_b);
}

// Branch and bound over the pieces of `source`.
double Directed(const Matrix2Xd& source, const Matrix2Xd& target, double tolerance) {
  std::vector<Piece> open;
  double best = 0;
  for (int i = 0; i < source.cols(); ++i) {
    const Vector2d a = source.col(i), b = source.col((i + 1) % source.cols());
    open.push_back({a, b, FindNearest(a, target), FindNearest(b, target)});
    best = std::max(best, open.back().near_a.distance);
  }
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    if (UpperBound(piece, target) <= best + tolerance) continue;
    const Vector2d middle = 0.5 * (piece.a + piece.b);
    const Nearest near_middle = FindNearest(middle, target);
    best = std::max(best, near_middle.distance);
    open.push_back({piece.a, middle, piece.near_a, near_middle});
    open.push_back({middle, piece.b, near_middle, piece.near_b});
  }
  return best;
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

Surface ToSurface(const Mesh& mesh, const Eigen::VectorXd& x, const std::string& where) {
  CHECK_EQ(x.size(), 3 * mesh.num_vertices());
  if (!x.allFinite()) throw InputError(where, "a position is not finite");
  Surface surface;
  std::vector<Surface::Vertex_index> vertices;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    vertices.push_back(surface.add_vertex({x[3 * i], x[3 * i + 1], x[3 * i + 2]}));
  }
  for (const Face& face : mesh.faces) {
    const int* v = face.vertex;
    const auto index = surface.add_face(vertices[v[0]], vertices[v[1]], vertices[v[2]]);
    CHECK(index != Surface::null_face()) << "BuildMesh accepts manifold meshes only";
  }
  return surface;
}

}  // namespace

double HausdorffOfPolygons(const Matrix2Xd& a, const Matrix2Xd& b, double tolerance) {
  CHECK_GT(a.cols(), 0);
  CHECK_GT(b.cols(), 0);
  CHECK(a.allFinite() && b.allFinite());
  CHECK_GT(tolerance, 0);
  return std::max(Directed(a, b, tolerance), Directed(b, a, tolerance));
}

double HausdorffOfMeshes(const Mesh& mesh_a, const Eigen::VectorXd& x_a, const Mesh& mesh_b,
                         const Eigen::VectorXd& x_b, const std::string& where, double tolerance) {
  return CGAL::Polygon_mesh_processing::bounded_error_symmetric_Hausdorff_distance<
      CGAL::Sequential_tag>(ToSurface(mesh_a, x_a, where), ToSurface(mesh_b, x_b, where),
                            tolerance);
}

}  // namespace drape
