// SPDX-License-Identifier: Apache-2.0
// distance.h of CGAL 5.5 does not compile before the kernel.
// clang-format off
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair.h>
// clang-format on
#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;

// A closed polygon and the arc length at each of its vertices.
struct Curve {
  explicit Curve(const Matrix2Xd& polygon) : points(polygon), arc(polygon.cols() + 1) {
    arc[0] = 0;
    for (int i = 0; i < size(); ++i) arc[i + 1] = arc[i] + Edge(i).norm();
  }
  int size() const { return static_cast<int>(points.cols()); }
  Vector2d Edge(int i) const { return points.col((i + 1) % size()) - points.col(i); }
  double DistanceTo(const Vector2d& p, int segment) const {
    return DistanceToSegment(p, points.col(segment), points.col((segment + 1) % size()));
  }

  const Matrix2Xd& points;
  Eigen::VectorXd arc;
};

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  int segment = -1;
};

// Finds the segment of the curve that is nearest to p. After a segment at `distance`, no segment
// can be nearer than `best` until the curve has run the length distance − best, so those in between
// are skipped. `guess` is a segment that is probably near.
Nearest FindNearest(const Vector2d& p, const Curve& curve, int guess) {
  Nearest nearest{curve.DistanceTo(p, guess), guess};
  for (int i = 0; i < curve.size(); ++i) {
    const double distance = curve.DistanceTo(p, i);
    if (distance < nearest.distance) nearest = {distance, i};
    const double reach = curve.arc[i + 1] + distance - nearest.distance;
    while (i + 1 < curve.size() && curve.arc[i + 2] < reach) ++i;
  }
  return nearest;
}

struct Piece {
  Vector2d a, b;
  Nearest near_a, near_b;
};

// The distance to ONE segment of the target is convex along the piece, so its larger end value
// bounds the distance to the target on the whole piece.
double UpperBound(const Piece& piece, const Curve& target) {
  const double by_a =
      std::max(piece.near_a.distance, target.DistanceTo(piece.b, piece.near_a.segment));
  const double by_b =
      std::max(piece.near_b.distance, target.DistanceTo(piece.a, piece.near_b.segment));
  return std::min(by_a, by_b);
}

// The directed distance by branch and bound over the pieces of `source`.
double Directed(const Curve& source, const Curve& target, double tolerance) {
  std::vector<Nearest> nearest;
  for (int i = 0; i < source.size(); ++i) {
    const int guess = i == 0 ? 0 : nearest.back().segment;
    nearest.push_back(FindNearest(source.points.col(i), target, guess));
  }
  std::vector<Piece> open;
  double best = 0;
  for (int i = 0; i < source.size(); ++i) {
    const int next = (i + 1) % source.size();
    open.push_back({source.points.col(i), source.points.col(next), nearest[i], nearest[next]});
    best = std::max(best, nearest[i].distance);
  }
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    if (UpperBound(piece, target) <= best + tolerance) continue;
    const Vector2d middle = 0.5 * (piece.a + piece.b);
    const Nearest near_middle = FindNearest(middle, target, piece.near_a.segment);
    best = std::max(best, near_middle.distance);
    open.push_back({piece.a, middle, piece.near_a, near_middle});
    open.push_back({middle, piece.b, near_middle, piece.near_b});
  }
  return best;
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

Surface ToSurface(const ObjSurface& soup, const std::string& where) {
  if (!soup.x.allFinite()) throw InputError(where, "a position is not finite");
  std::vector<Kernel::Point_3> points;
  for (Eigen::Index i = 0; i < soup.x.size(); i += 3)
    points.emplace_back(soup.x[i], soup.x[i + 1], soup.x[i + 2]);
  std::vector<std::array<std::size_t, 3>> triangles;
  for (const auto& [i, j, k] : soup.triangles) {
    if (CGAL::collinear(points.at(i), points.at(j), points.at(k))) continue;
    triangles.push_back({std::size_t(i), std::size_t(j), std::size_t(k)});
  }
  if (triangles.empty())
    throw InputError(where, "found no triangle of positive area, expected at least one");
  namespace PMP = CGAL::Polygon_mesh_processing;
  PMP::orient_polygon_soup(points, triangles);
  Surface surface;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, surface);
  PMP::remove_isolated_vertices(surface);
  return surface;
}

}  // namespace

double HausdorffOfPolygons(const Matrix2Xd& a, const Matrix2Xd& b, double tolerance) {
  CHECK_GT(a.cols(), 0);
  CHECK_GT(b.cols(), 0);
  CHECK(a.allFinite() && b.allFinite());
  CHECK_GT(tolerance, 0);
  const Curve curve_a(a), curve_b(b);
  return std::max(Directed(curve_a, curve_b, tolerance), Directed(curve_b, curve_a, tolerance));
}

double HausdorffOfSurfaces(const ObjSurface& a, const ObjSurface& b, const std::string& where,
                           double tolerance) {
  return CGAL::Polygon_mesh_processing::bounded_error_symmetric_Hausdorff_distance<
      CGAL::Sequential_tag>(ToSurface(a, where), ToSurface(b, where), tolerance);
}

}  // namespace drape
