// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/self_intersection.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>
#include <glog/logging.h>

#include <algorithm>

namespace drape {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = std::array<int, 3>;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

std::vector<Point> MakePoints(const std::vector<Triangle>& triangles, const Eigen::VectorXd& x) {
  CHECK_EQ(x.size() % 3, 0);
  CHECK(x.allFinite());
  std::vector<Point> points;
  for (Eigen::Index i = 0; i < x.size(); i += 3) points.emplace_back(x[i], x[i + 1], x[i + 2]);
  for (const Triangle& t : triangles)
    for (const int i : t) CHECK(i >= 0 && i < static_cast<int>(points.size())) << i;
  return points;
}

// Turns the corners, keeping their order, so that those that `other` has too come first. Returns
// how many these are.
int SharedCornersFirst(const Triangle& other, Triangle& t) {
  const auto shared = [&](int i) {
    return std::find(other.begin(), other.end(), i) != other.end();
  };
  const int count = static_cast<int>(std::count_if(t.begin(), t.end(), shared));
  while (count > 0 && count < 3 && !(shared(t[0]) && (count == 1 || shared(t[1]))))
    std::rotate(t.begin(), t.begin() + 1, t.end());
  return count;
}

class PairTest {
 public:
  PairTest(const std::vector<Triangle>& triangles, const Eigen::VectorXd& x)
      : triangles_(triangles), points_(MakePoints(triangles, x)) {}

  bool Degenerate(int face) const {
    const Triangle& t = triangles_[face];
    return CGAL::collinear(points_[t[0]], points_[t[1]], points_[t[2]]);
  }

  bool Meet(int first, int second) const {
    Triangle a = triangles_[first], b = triangles_[second];
    SharedCornersFirst(a, b);
    switch (SharedCornersFirst(b, a)) {
      case 0:
        return CGAL::do_intersect(Shape(a), Shape(b));
      case 1:
        return CGAL::do_intersect(Shape(a), Opposite(b)) ||
               CGAL::do_intersect(Shape(b), Opposite(a));
      case 2:  // folded flat onto one another
        return CGAL::coplanar(points_[a[0]], points_[a[1]], points_[a[2]], points_[b[2]]) &&
               CGAL::coplanar_orientation(points_[a[0]], points_[a[1]], points_[a[2]],
                                          points_[b[2]]) == CGAL::POSITIVE;
      default:
        return true;
    }
  }

  Box Bounds(int face) const { return Box(Shape(triangles_[face]).bbox(), face); }

 private:
  Kernel::Triangle_3 Shape(const Triangle& t) const {
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
  }
  Kernel::Segment_3 Opposite(const Triangle& t) const { return {points_[t[1]], points_[t[2]]}; }

  const std::vector<Triangle>& triangles_;
  std::vector<Point> points_;
};

}  // namespace

std::vector<std::pair<int, int>> FindSelfIntersections(const std::vector<Triangle>& triangles,
                                                       const Eigen::VectorXd& x, int most) {
  const PairTest test(triangles, x);
  std::vector<std::pair<int, int>> found;
  std::vector<Box> boxes;
  for (int face = 0; face < static_cast<int>(triangles.size()); ++face) {
    if (test.Degenerate(face)) {
      found.emplace_back(face, face);
    } else {
      boxes.push_back(test.Bounds(face));
    }
  }
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
    const auto [first, second] = std::minmax({a.info(), b.info()});
    if (test.Meet(first, second)) found.emplace_back(first, second);
  });
  std::sort(found.begin(), found.end());
  if (static_cast<int>(found.size()) > most) found.resize(std::max(0, most));
  return found;
}

int CountSelfIntersections(const Mesh& mesh, const Eigen::VectorXd& x) {
  constexpr int kMost = 1000;
  return static_cast<int>(FindSelfIntersections(ListTriangles(mesh), x, kMost).size());
}

}  // namespace drape
