// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

Eigen::Matrix2Xd Circle(int n, double radius, double shift = 0) {
  Eigen::Matrix2Xd points = ProfilePolygon(Eigen::VectorXd::Constant(n, radius));
  points.row(0).array() += shift;
  return points;
}

TEST(HausdorffOfPolygons, OfCircles) {
  EXPECT_NEAR(HausdorffOfPolygons(Circle(720, 0.10), Circle(720, 0.13)), 0.03, 2e-6);
  EXPECT_NEAR(HausdorffOfPolygons(Circle(720, 0.10), Circle(720, 0.10, 0.02)), 0.02, 2e-6);
  EXPECT_NEAR(HausdorffOfPolygons(Circle(720, 0.10), Circle(720, 0.12, 0.01)), 0.03, 2e-6);
}

TEST(HausdorffOfPolygons, IsZeroForTheSameCurveInOtherVertices) {
  const Eigen::Matrix2Xd circle = Circle(36, 0.1);
  Eigen::Matrix2Xd finer(2, 72);
  for (int i = 0; i < 36; ++i) {
    finer.col(2 * i) = circle.col(i);
    finer.col(2 * i + 1) = 0.5 * (circle.col(i) + circle.col((i + 1) % 36));
  }
  EXPECT_LT(HausdorffOfPolygons(circle, finer), 1e-12);
}

// The farthest point lies inside an edge: between the teeth of the other curve, not at a vertex.
TEST(HausdorffOfPolygons, CountsThePointsBetweenVertices) {
  Eigen::Matrix2Xd flat(2, 4), notched(2, 5);
  flat << 0, 4, 4, 0,  //
      0, 0, -1, -1;
  notched << 0, 2, 4, 4, 0,  //
      0, 1, 0, -1, -1;
  // (2, 0) of the flat edge is 2/√5 away from both slopes; (2, 1) is 1 away from the flat edge.
  EXPECT_NEAR(HausdorffOfPolygons(flat, notched), 1, 1e-7);
  // With a notch almost down to the other side, the farthest point is the middle of the flat edge.
  Eigen::Matrix2Xd deep = notched;
  deep.col(1) << 2, -0.999;
  EXPECT_NEAR(HausdorffOfPolygons(flat, deep), 2 * 0.999 / std::hypot(2, 0.999), 1e-6);
}

// Compares with dense samples of one curve against all segments of the other, for two curves with
// many folds.
TEST(HausdorffOfPolygons, IsThatOfDenseSamples) {
  const auto folded = [](int n, int folds, double phase) {
    Eigen::VectorXd radius(n);
    for (int k = 0; k < n; ++k)
      radius[k] = 0.12 + 0.02 * std::cos(folds * 2 * M_PI * k / n + phase);
    return ProfilePolygon(radius);
  };
  const Eigen::Matrix2Xd a = folded(97, 7, 0.3), b = folded(60, 5, 1.1);
  const auto directed = [](const Eigen::Matrix2Xd& from, const Eigen::Matrix2Xd& to) {
    double largest = 0;
    for (int i = 0; i < 200 * from.cols(); ++i) {
      const double t = i % 200 / 200.0;
      const Eigen::Vector2d p =
          (1 - t) * from.col(i / 200) + t * from.col((i / 200 + 1) % from.cols());
      double least = 1;
      for (int j = 0; j < to.cols(); ++j) {
        const Eigen::Vector2d start = to.col(j), edge = to.col((j + 1) % to.cols()) - start;
        const double along = std::clamp((p - start).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (p - start - along * edge).norm());
      }
      largest = std::max(largest, least);
    }
    return largest;
  };
  EXPECT_NEAR(HausdorffOfPolygons(a, b), std::max(directed(a, b), directed(b, a)), 5e-6);
}

ObjSurface SurfaceAt(const Mesh& mesh, const Eigen::VectorXd& x) {
  return {x, ListTriangles(mesh)};
}

double DistanceOfMeshes(const Mesh& a, const Eigen::VectorXd& x_a, const Mesh& b,
                        const Eigen::VectorXd& x_b) {
  return HausdorffOfSurfaces(SurfaceAt(a, x_a), SurfaceAt(b, x_b), "mesh");
}

TEST(HausdorffOfSurfaces, OfAShiftedAndAnEqualDisc) {
  const Mesh disc = MakeDisc(4, 24, 0.15);
  Eigen::VectorXd raised = disc.rest_x;
  for (int i = 0; i < disc.num_vertices(); ++i) raised[3 * i + 2] += 0.02;
  EXPECT_NEAR(DistanceOfMeshes(disc, disc.rest_x, disc, raised), 0.02, 2e-4);
  EXPECT_NEAR(DistanceOfMeshes(disc, disc.rest_x, disc, disc.rest_x), 0, 2e-4);
}

TEST(HausdorffOfSurfaces, OfConcentricDiscsOfOtherTopology) {
  const Mesh a = MakeDisc(4, 90, 0.15), b = MakeDisc(3, 80, 0.10);
  EXPECT_NEAR(DistanceOfMeshes(a, a.rest_x, b, b.rest_x), 0.05, 3e-4);
}

TEST(HausdorffOfSurfaces, RejectsNonFinitePositions) {
  const Mesh disc = MakeDisc(2, 12, 0.15);
  Eigen::VectorXd x = disc.rest_x;
  x[7] = std::nan("");
  EXPECT_THROW(DistanceOfMeshes(disc, x, disc, disc.rest_x), InputError);
}

ObjSurface Quad(double z, double width) {
  ObjSurface surface;
  surface.x.resize(12);
  surface.x << 0, 0, z, width, 0, z, width, 0.1, z, 0, 0.1, z;
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  return surface;
}

TEST(HausdorffOfSurfaces, OfTrianglesThatAreNoManifold) {
  ObjSurface a = Quad(0, 0.1);
  a.triangles.push_back({2, 1, 0});  // the first triangle again, reversed
  a.triangles.push_back({0, 1, 1});
  a.x.conservativeResize(15);
  a.x.tail<3>() << 9, 9, 9;  // a vertex without a triangle
  EXPECT_NEAR(HausdorffOfSurfaces(a, Quad(0.03, 0.1), "s"), 0.03, 2e-4);
  EXPECT_NEAR(HausdorffOfSurfaces(a, Quad(0, 0.14), "s"), 0.04, 2e-4);
  EXPECT_NEAR(HausdorffOfSurfaces(Quad(0, 0.14), a, "s"), 0.04, 2e-4);
}

TEST(HausdorffOfSurfaces, NeedsATriangle) {
  ObjSurface a = Quad(0, 0.1);
  a.triangles = {{0, 1, 1}};
  EXPECT_THROW(HausdorffOfSurfaces(a, Quad(0, 0.1), "s"), InputError);
}

}  // namespace
}  // namespace drape
