// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth/contact/sheets.h"

namespace drape {
namespace {

constexpr Contact kSurface{.thickness = 1e-3, .range = 2e-3};

Eigen::VectorXd VertexAreas(const Mesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_vertices());
  for (const Face& face : mesh.faces)
    for (const int i : face.vertex) areas[i] += face.area / 3.0;
  return areas;
}

Eigen::VectorXd RandomMoves(Eigen::Index size, double scale, std::mt19937_64& random) {
  Eigen::VectorXd moves(size);
  for (double& part : moves) part = scale * SampleNormal(random);
  return moves;
}

// Two sheets one over the other, the upper one turned and bent, so that vertices, faces and edges
// push.
class TwoSheets : public testing::Test {
 protected:
  TwoSheets()
      : mesh_(test::Together({MakeStrip(0.05, 0.04, 5, 4), MakeStrip(0.05, 0.04, 4, 5)})),
        contact_(mesh_, VertexAreas(mesh_), kSurface) {
    // At rest they are far apart.
    x_ = mesh_.rest_x;
    std::mt19937_64 random(1);
    x_ += RandomMoves(x_.size(), 2e-4, random);
    const int lower = MakeStrip(0.05, 0.04, 5, 4).num_vertices();
    for (int i = lower; i < mesh_.num_vertices(); ++i) {
      auto place = x_.segment<3>(3 * i);
      place = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) * place;
      place.z() += kSurface.thickness + 0.6e-3 + 20.0 * place.x() * place.x() * 0.02;
    }
    Eigen::VectorXd none = Eigen::VectorXd::Zero(x_.size());
    LimitStep(contact_, x_, none);
  }

  Mesh mesh_;
  SurfaceContact contact_;
  Eigen::VectorXd x_;
};

TEST_F(TwoSheets, ForcesAreTheSlopeOfTheEnergy) {
  std::mt19937_64 random(2);
  const auto energy = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    return AddPairForces(contact_.FindActivePairs(x), f);
  };
  Eigen::VectorXd f = Eigen::VectorXd::Zero(x_.size());
  ASSERT_GT(AddPairForces(contact_.FindActivePairs(x_), f), 0.0);
  ASSERT_GT(contact_.FindActivePairs(x_).size(), 20U);
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd way = RandomMoves(x_.size(), 1.0, random);
    constexpr double kStep = 1e-8;
    const double slope = (energy(x_ + kStep * way) - energy(x_ - kStep * way)) / (2.0 * kStep);
    EXPECT_NEAR(-f.dot(way), slope, 1e-6 * f.norm() * way.norm());
  }
}

TEST_F(TwoSheets, ForcesAddUpToNothing) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(x_.size());
  AddPairForces(contact_.FindActivePairs(x_), f);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = sum;
  for (Eigen::Index i = 0; i < f.size(); i += 3) {
    sum += f.segment<3>(i);
    moment += Eigen::Vector3d(x_.segment<3>(i)).cross(Eigen::Vector3d(f.segment<3>(i)));
  }
  EXPECT_LT(sum.norm(), 1e-14 * f.norm() * f.size());
  EXPECT_LT(moment.norm(), 1e-14 * f.norm() * f.size() * x_.norm());
}

// The stiffness is that of the energy where all of its curvature is positive, and more elsewhere.
TEST_F(TwoSheets, StiffnessBoundsTheSlopeOfTheForces) {
  std::mt19937_64 random(3);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(x_.size(), x_.size());
  ForEachPairStiffness(contact_.FindActivePairs(x_), StiffnessPart::kPositive,
                       [&](int i, int j, const Eigen::Matrix3d& block) {
                         EXPECT_LE(i, j);
                         stiffness.block<3, 3>(3 * i, 3 * j) += block;
                         if (i != j) stiffness.block<3, 3>(3 * j, 3 * i) += block.transpose();
                       });
  EXPECT_LT((stiffness - stiffness.transpose()).norm(), 1e-12 * stiffness.norm());
  const auto forces = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    AddPairForces(contact_.FindActivePairs(x), f);
    return f;
  };
  // Along the force, which mostly opens the gaps, they nearly agree.
  const Eigen::VectorXd up = forces(x_).normalized();
  constexpr double kStep = 1e-8;
  const Eigen::VectorXd slope = (forces(x_ - kStep * up) - forces(x_ + kStep * up)) / (2.0 * kStep);
  EXPECT_NEAR(up.dot(stiffness * up), up.dot(slope), 0.05 * up.dot(slope));
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd way = RandomMoves(x_.size(), 1.0, random);
    const double curvature =
        way.dot(forces(x_ - kStep * way) - forces(x_ + kStep * way)) / (2.0 * kStep);
    EXPECT_GT(way.dot(stiffness * way), curvature - 1e-4 * std::abs(curvature));
  }
}

// The pressure is that of an obstacle. Where edges nearly meet, their nearest points are not one
// above the other: a sheet that slides over another feels its mesh.
TEST(SurfaceContact, ParallelSheetsHaveThePressureOfTheirGap) {
  constexpr Contact kCloth{};
  constexpr double kGap = 1.5e-4, kSide = 0.1;
  const Mesh lower = MakeStrip(0.2, 0.2, 8, 9);
  const Mesh mesh = test::Together({lower, MakeStrip(kSide, kSide, 5, 6)});
  SurfaceContact contact(mesh, VertexAreas(mesh), kCloth);
  const double expected =
      -kCloth.stiffness * EvaluateBarrier(kGap, kCloth.range).slope * kSide * kSide;
  double up = 0.0, most_aside = 0.0;
  int places = 0;
  for (double slide = 0.03; slide < 0.07; slide += 0.0013, ++places) {
    Eigen::VectorXd x = mesh.rest_x;
    for (int i = lower.num_vertices(); i < mesh.num_vertices(); ++i)
      x.segment<3>(3 * i) += Eigen::Vector3d(slide, 0.3 * slide, kCloth.thickness + kGap);
    Eigen::VectorXd none = Eigen::VectorXd::Zero(x.size()), f = none;
    LimitStep(contact, x, none);
    AddPairForces(contact.FindActivePairs(x), f);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 3 * lower.num_vertices(); i < f.size(); i += 3) sum += f.segment<3>(i);
    EXPECT_NEAR(sum.z(), expected, 0.4 * expected) << slide;
    up += sum.z();
    most_aside = std::max(most_aside, sum.head<2>().norm() / sum.z());
  }
  EXPECT_NEAR(up / places, expected, 0.2 * expected);
  EXPECT_LT(most_aside, 0.06);
}

// Pairs that are near at rest, here all of a fine mesh, do not push: a flat sheet is without force.
TEST(SurfaceContact, AFlatSheetDoesNotPushItself) {
  const Mesh mesh = MakeStrip(0.02, 0.02, 20, 20);
  SurfaceContact contact(mesh, VertexAreas(mesh), kSurface);
  Eigen::VectorXd none = Eigen::VectorXd::Zero(mesh.rest_x.size()), f = none;
  LimitStep(contact, mesh.rest_x, none);
  EXPECT_EQ(AddPairForces(contact.FindActivePairs(mesh.rest_x), f), 0.0);
  EXPECT_EQ(f.norm(), 0.0);
  EXPECT_EQ(contact.SmallestGap(mesh.rest_x), kSurface.range);
}

// Moves of any size, one after another, none of which lets the cloth through itself.
TEST(SurfaceContact, ShortenedMovesNeverCross) {
  const Mesh mesh = test::Together({MakeStrip(0.1, 0.05, 8, 5), MakeStrip(0.1, 0.05, 7, 6)});
  SurfaceContact contact(mesh, VertexAreas(mesh), kSurface);
  Eigen::VectorXd x = mesh.rest_x;
  const int lower = MakeStrip(0.1, 0.05, 8, 5).num_vertices();
  for (int i = lower; i < mesh.num_vertices(); ++i) x[3 * i + 2] += 0.005;
  const auto triangles = ListTriangles(mesh);
  ASSERT_TRUE(FindSelfIntersections(triangles, x).empty());
  std::mt19937_64 random(4);
  int shortened = 0;
  for (int k = 0; k < 300; ++k) {
    const double scale = std::pow(10.0, std::uniform_real_distribution(-4.0, -1.0)(random));
    Eigen::VectorXd dx = RandomMoves(x.size(), scale, random);
    // The sheets are driven together.
    for (Eigen::Index i = 2; i < dx.size(); i += 3) dx[i] += i < 3 * lower ? scale : -scale;
    const Eigen::VectorXd meant = dx;
    const bool changed = LimitStep(contact, x, dx);
    EXPECT_EQ(changed, dx != meant);
    shortened += changed;
    for (const double share : {0.3, 0.7, 1.0}) {
      const Eigen::VectorXd at = x + share * dx;
      ASSERT_TRUE(FindSelfIntersections(triangles, at).empty()) << k << " " << share;
    }
    x += dx;
    EXPECT_GT(contact.SmallestGap(x), -kSurface.thickness);
  }
  EXPECT_GT(shortened, 200);
}

// A sheet that lies bent around a ball of few facets, which has moved.
class SheetOnBall : public testing::Test {
 protected:
  SheetOnBall() : contact_(mesh_, VertexAreas(mesh_), std::nullopt) {
    const Eigen::Matrix3Xd before = ball_.x.colwise() - move_;
    contact_.SetObstacles(
        {.thickness = kSurface.thickness,
         .range = kSurface.range,
         .obstacles = {std::make_shared<const SurfaceObstacle>(ball_.x, ball_.triangles, before)}});
    x_ = mesh_.rest_x;
    std::mt19937_64 random(6);
    for (Eigen::Index i = 0; i < x_.size(); i += 3) {
      auto place = x_.segment<3>(i);
      place.head<2>() -= Eigen::Vector2d(0.02, 0.02);
      place.z() = 0.05;
      place *= (kRadius + kSurface.thickness) / place.norm();
    }
    x_ += RandomMoves(x_.size(), 3e-4, random);
  }
  double Energy(const Eigen::VectorXd& x) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    return AddPairForces(contact_.FindActivePairs(x), f);
  }
  Eigen::VectorXd Forces(const Eigen::VectorXd& x) {
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    AddPairForces(contact_.FindActivePairs(x), f);
    return f;
  }

  static constexpr double kRadius = 0.05;
  test::ClosedMesh ball_ = test::MakeBall(kRadius, 2);
  Eigen::Vector3d move_ = Eigen::Vector3d(1e-3, 2e-3, -3e-3);  // of the ball in the step
  Mesh mesh_ = MakeStrip(0.04, 0.04, 4, 4);
  SurfaceContact contact_;
  Eigen::VectorXd x_;
};

TEST_F(SheetOnBall, ForcesAreTheSlopeOfTheEnergy) {
  int vertices = 0, edges = 0;
  for (const ActivePair& touch : contact_.FindActivePairs(x_)) {
    EXPECT_TRUE(touch.of_obstacle());
    EXPECT_TRUE(touch.pair.of_edges || touch.pair.vertex[0] >= mesh_.num_vertices());
    ++(touch.pair.of_edges ? edges : vertices);
  }
  EXPECT_GT(vertices, 5);
  EXPECT_GT(edges, 20);
  const Eigen::VectorXd f = Forces(x_);
  std::mt19937_64 random(7);
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd way = RandomMoves(x_.size(), 1.0, random);
    constexpr double kStep = 1e-8;
    const double slope = (Energy(x_ + kStep * way) - Energy(x_ - kStep * way)) / (2.0 * kStep);
    EXPECT_NEAR(-f.dot(way), slope, 1e-6 * f.norm() * way.norm());
  }
}

TEST_F(SheetOnBall, TheWholeStiffnessIsTheSlopeOfTheForces) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(x_.size(), x_.size());
  ForEachPairStiffness(contact_.FindActivePairs(x_), StiffnessPart::kWhole,
                       [&](int i, int j, const Eigen::Matrix3d& block) {
                         ASSERT_LT(j, mesh_.num_vertices());
                         stiffness.block<3, 3>(3 * i, 3 * j) += block;
                         if (i != j) stiffness.block<3, 3>(3 * j, 3 * i) += block.transpose();
                       });
  std::mt19937_64 random(8);
  for (int k = 0; k < 20; ++k) {
    const Eigen::VectorXd way = RandomMoves(x_.size(), 1.0, random);
    constexpr double kStep = 1e-9;
    const Eigen::VectorXd slope =
        (Forces(x_ - kStep * way) - Forces(x_ + kStep * way)) / (2.0 * kStep);
    EXPECT_LT((stiffness * way - slope).norm(), 1e-6 * slope.norm());
  }
}

// A point of the cloth that goes with the obstacle does not slip, one that rests slips by its move.
TEST_F(SheetOnBall, SlipIsRelativeToTheObstacle) {
  const Eigen::VectorXd led = x_ - move_.replicate(mesh_.num_vertices(), 1);
  const ActivePairs touches = contact_.FindActivePairs(x_);
  ASSERT_FALSE(touches.empty());
  for (const ActivePair& touch : touches) {
    // A face that pushes back a vertex is the second part of its pair.
    const double side = touch.pair.of_edges ? 1.0 : -1.0;
    const Rub rub = MakeRub(touch, led);
    EXPECT_LT((rub.Point(x_) - rub.start).norm(), 1e-15);
    const Rub at_rest = MakeRub(touch, x_);
    EXPECT_LT((at_rest.Point(x_) - at_rest.start + side * move_).norm(), 1e-15);
    for (const int i : rub.vertex) EXPECT_LT(i, mesh_.num_vertices());
  }
}

// A ridge that jumps through a coarse sheet, whose vertices are far from it, takes it along.
TEST(SurfaceContact, ASheetGivesWayToARidge) {
  const Mesh mesh = MakeStrip(0.3, 0.3, 3, 3);
  const test::ClosedMesh wedge = test::MakeWedge(0.02, 0.02, 0.05);
  const auto at = [&](double z) -> Eigen::Matrix3Xd {
    return wedge.x.colwise() + Eigen::Vector3d(0.16, 0.14, z);
  };
  SurfaceContact contact(mesh, VertexAreas(mesh), std::nullopt);
  contact.SetObstacles({.obstacles = {std::make_shared<const SurfaceObstacle>(
                            at(0.02), wedge.triangles, at(-0.001))}});
  Eigen::VectorXd moves = Eigen::VectorXd::Zero(mesh.rest_x.size());
  EXPECT_FALSE(IsStepFree(contact, mesh.rest_x, moves));
  ASSERT_FALSE(FindFreeStep(contact, mesh.rest_x, moves));
  const Eigen::VectorXd x = mesh.rest_x + moves;
  std::vector<std::array<int, 3>> all = ListTriangles(mesh);
  for (const auto& [p, q, r] : wedge.triangles)
    all.push_back({mesh.num_vertices() + p, mesh.num_vertices() + q, mesh.num_vertices() + r});
  Eigen::VectorXd both(x.size() + wedge.x.size());
  both << x, at(0.02).reshaped();
  EXPECT_TRUE(FindSelfIntersections(all, both).empty());
  EXPECT_GT(moves(Eigen::seq(2, Eigen::last, 3)).maxCoeff(), 0.02);
  // What is far away stays.
  EXPECT_EQ(moves.head<3>().norm(), 0.0);
}

}  // namespace
}  // namespace drape
