// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/disc.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using std::numbers::pi;

double SmallestAngle(const Mesh& mesh) {  // [degrees]
  double smallest = 180;
  for (const Face& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d a = mesh.uv.col(face.vertex[k]);
      const Eigen::Vector2d e1 = mesh.uv.col(face.vertex[(k + 1) % 3]) - a;
      const Eigen::Vector2d e2 = mesh.uv.col(face.vertex[(k + 2) % 3]) - a;
      smallest = std::min(smallest, std::acos(e1.normalized().dot(e2.normalized())) * 180 / pi);
    }
  }
  return smallest;
}

// The sorted angles in [0, 2π) of the vertices within 1e-15 (relative) of a radius, and the indices
// of these vertices.
std::map<double, int> Ring(const Mesh& mesh, double radius) {
  std::map<double, int> ring;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const Eigen::Vector2d p = mesh.uv.col(i);
    if (std::abs(p.norm() - radius) > 1e-15 * radius) continue;
    const double angle = std::atan2(p.y(), p.x());
    ring[angle < -1e-9 ? angle + 2 * pi : angle] = i;
  }
  return ring;
}

std::set<std::pair<int, int>> UndirectedEdges(const Mesh& mesh) {
  std::set<std::pair<int, int>> edges;
  for (const Face& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) {
      edges.insert(std::minmax({face.vertex[k], face.vertex[(k + 1) % 3]}));
    }
  }
  return edges;
}

void ExpectEvenRing(const Mesh& mesh, double radius) {
  const std::map<double, int> ring = Ring(mesh, radius);
  const auto edges = UndirectedEdges(mesh);
  const double mean_edge = std::sqrt(4 / std::numbers::sqrt3 * pi * .15 * .15 / mesh.num_faces());
  EXPECT_NEAR(2 * pi * radius / ring.size(), mean_edge, .1 * mean_edge);
  for (auto it = ring.begin(); it != ring.end(); ++it) {
    const auto next = std::next(it) == ring.end() ? ring.begin() : std::next(it);
    const double gap = next->first - it->first + (next == ring.begin() ? 2 * pi : 0);
    EXPECT_NEAR(gap, 2 * pi / ring.size(), 1e-12);
    EXPECT_TRUE(edges.contains(std::minmax({it->second, next->second})));
  }
}

class Disc : public ::testing::TestWithParam<int> {
 protected:
  const Mesh mesh_ = MakeDisc({.target_vertices = GetParam()});
};

TEST_P(Disc, HasTheVerticesAskedForAndFillsTheCircle) {
  EXPECT_EQ(mesh_.num_vertices(), GetParam());
  double area = 0, smallest = 1, largest = 0;
  for (const Face& face : mesh_.faces) {
    area += face.area;
    smallest = std::min(smallest, face.area);
    largest = std::max(largest, face.area);
  }
  const double hem = static_cast<double>(mesh_.boundary_loops[0].size());
  EXPECT_NEAR(area, hem / 2 * .15 * .15 * std::sin(2 * pi / hem), 1e-14);
  EXPECT_LT(largest / smallest, 3);
  EXPECT_EQ(mesh_.boundary_loops.size(), 1u);
}

TEST_P(Disc, HasGoodTriangles) { EXPECT_GE(SmallestAngle(mesh_), 28); }

TEST_P(Disc, HasEvenRingsOnSupportAndHem) {
  ExpectEvenRing(mesh_, .09);
  ExpectEvenRing(mesh_, .15);
  EXPECT_EQ(Ring(mesh_, .15).size(), mesh_.boundary_loops[0].size());
}

TEST_P(Disc, HasNoPreferredEdgeDirection) {
  std::array<double, 12> share = {};  // bins of 15°; 1 = uniform
  std::complex<double> second = 0, fourth = 0;
  for (const Hinge& hinge : mesh_.hinges) {
    const Eigen::Vector2d d = mesh_.uv.col(hinge.vertex[1]) - mesh_.uv.col(hinge.vertex[0]);
    const double angle = std::atan2(d.y(), d.x());
    const double turned = angle < 0 ? angle + pi : angle;
    share[std::min(11, static_cast<int>(turned / pi * 12))] += 12. / mesh_.num_hinges();
    second += std::polar(1. / mesh_.num_hinges(), 2 * angle);
    fourth += std::polar(1. / mesh_.num_hinges(), 4 * angle);
  }
  EXPECT_GT(*std::min_element(share.begin(), share.end()), .75);
  EXPECT_LT(*std::max_element(share.begin(), share.end()), 1.25);
  // The second and fourth harmonics are all that a bend stiffness (a fourth-order tensor) depends
  // on in the edge directions of the mesh.
  EXPECT_LT(std::abs(second), .02);
  EXPECT_LT(std::abs(fourth), .02);
}

TEST_P(Disc, IsTheSameOnEachRun) {
  const Mesh again = MakeDisc({.target_vertices = GetParam()});
  EXPECT_EQ(again.rest_x, mesh_.rest_x);
  ASSERT_EQ(again.num_faces(), mesh_.num_faces());
  for (int f = 0; f < mesh_.num_faces(); ++f) {
    EXPECT_TRUE(
        std::equal(again.faces[f].vertex, again.faces[f].vertex + 3, mesh_.faces[f].vertex));
  }
}

TEST_P(Disc, IsFlatWithUvInMetres) {
  for (int i = 0; i < mesh_.num_vertices(); ++i) {
    EXPECT_EQ(mesh_.rest_x[3 * i], mesh_.uv(0, i));
    EXPECT_EQ(mesh_.rest_x[3 * i + 1], mesh_.uv(1, i));
    EXPECT_EQ(mesh_.rest_x[3 * i + 2], 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Disc, ::testing::Values(300, 1200, 2700, 5000));

TEST(DiscLimits, SmallAndOddDiscsAreGoodToo) {
  for (const DiscOptions& options :
       {DiscOptions{.target_vertices = 100}, DiscOptions{.target_vertices = 137},
        DiscOptions{.radius = .12, .support_radius = .06, .target_vertices = 400},
        DiscOptions{.radius = 1.5, .support_radius = 1.2, .target_vertices = 1000}}) {
    const Mesh mesh = MakeDisc(options);
    EXPECT_EQ(mesh.num_vertices(), options.target_vertices);
    EXPECT_GE(SmallestAngle(mesh), 25) << options.target_vertices;
    EXPECT_GT(Ring(mesh, options.support_radius).size(), 10u);
  }
}

TEST(DiscLimits, RejectsWhatCannotBeMeshed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_INPUT_ERROR(MakeDisc({.target_vertices = 99}), "disc: 99 vertices, expected 100..1000000");
  EXPECT_INPUT_ERROR(MakeDisc({.target_vertices = 1000001}), "disc: 1000001 vertices");
  EXPECT_INPUT_ERROR(MakeDisc({.radius = .09}), "expected 0 < support radius < radius");
  EXPECT_INPUT_ERROR(MakeDisc({.radius = kNan}), "expected 0 < support radius < radius");
  EXPECT_INPUT_ERROR(MakeDisc({.support_radius = 0}), "expected 0 < support radius < radius");
  EXPECT_INPUT_ERROR(MakeDisc({.support_radius = .149}), "disc: too few vertices: edges of 0.008");
  EXPECT_INPUT_ERROR(MakeDisc({.support_radius = .001}), "disc: too few vertices");
}

}  // namespace
}  // namespace drape
