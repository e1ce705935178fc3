// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/random_drapes.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "physics/mesh/disc.h"

namespace drape {
namespace {

using std::numbers::pi;

constexpr double kSupport = 0.09, kTurn = 2 * pi * 25 / kBranchAngles;

// Folds of one order on a weaker wave that tells left from right.
Eigen::VectorXd Folded(int folds, double phase, int n = kBranchAngles) {
  Eigen::VectorXd r(n);
  for (int i = 0; i < n; ++i) {
    const double t = 2 * pi * i / n - phase;
    r[i] = .11 + .01 * std::cos(folds * t) + .004 * std::sin(2 * t);
  }
  return r;
}

TEST(BranchSignature, HasFoldsModesAndDrapeCoefficient) {
  const BranchSignature s = ComputeSignature(Folded(7, 0.3), {});
  EXPECT_EQ(s.folds, 7);
  ASSERT_EQ(s.modes.size(), 3u);
  EXPECT_EQ(s.modes[0].k, 7);
  EXPECT_NEAR(s.modes[0].amplitude_m, .01, 1e-12);
  EXPECT_NEAR(s.modes[0].phase, 7 * 0.3, 1e-10);
  EXPECT_EQ(s.modes[1].k, 2);
  EXPECT_NEAR(s.modes[1].amplitude_m, .004, 1e-12);
  EXPECT_NEAR(s.modes[1].phase, 2 * 0.3 + pi / 2, 1e-10);
  EXPECT_NEAR(s.modes[2].amplitude_m, 0, 1e-12);
  const double mean_square = .11 * .11 + (.01 * .01 + .004 * .004) / 2;
  EXPECT_NEAR(s.drape_coefficient, (mean_square - .09 * .09) / (.15 * .15 - .09 * .09), 1e-12);
  EXPECT_EQ(s.modes.size(), 3u);
}

TEST(BranchSignature, TellsFoldCountsApart) {
  EXPECT_EQ(ComputeSignature(Folded(6, 0), {}).folds, 6);
  EXPECT_EQ(ComputeSignature(Folded(6, 0), {}).modes[0].k, 6);
  for (const auto freedom : {OutlineFreedom::kFixed, OutlineFreedom::kRotationAndMirror}) {
    // Waves of different orders are orthogonal at each rotation.
    EXPECT_GT(MatchOutlines(Folded(6, 0), Folded(7, 1), freedom).rms, .01 - 1e-12);
  }
}

// The same on a cloth: a drape and the drape turned as a body.
class ClothBranch : public testing::Test {
 protected:
  Eigen::VectorXd Turned(double angle) const {
    Eigen::VectorXd x = drape_;
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).matrix();
    for (int i = 0; i < mesh_.num_vertices(); ++i) {
      x.segment<3>(3 * i) = turn * drape_.segment<3>(3 * i);
    }
    return x;
  }
  const Mesh mesh_ = MakeDisc({.target_vertices = 300});
  const Eigen::VectorXd drape_ = FlapsFromOutline(mesh_, kSupport, Folded(6, .2, 72), 1.0);
};

TEST_F(ClothBranch, OutlineTurnsWithTheCloth) {
  Eigen::VectorXd here, there;
  ASSERT_TRUE(DrapeOutline(mesh_, drape_, &here));
  ASSERT_TRUE(DrapeOutline(mesh_, Turned(kTurn), &there));
  const OutlineMatch match = MatchOutlines(there, here, OutlineFreedom::kRotation);
  EXPECT_LT(match.rms, 1e-12);
  EXPECT_NEAR(match.rotation, kTurn, 1e-12);
  const BranchSignature a = ComputeSignature(here, {}), b = ComputeSignature(there, {});
  EXPECT_EQ(a.folds, 6);
  EXPECT_EQ(a.folds, b.folds);
  EXPECT_NEAR(a.drape_coefficient, b.drape_coefficient, 1e-12);
  EXPECT_EQ(a.modes[0].k, b.modes[0].k);
  EXPECT_NEAR(std::remainder(b.modes[0].phase - a.modes[0].phase - 6 * kTurn, 2 * pi), 0, 1e-9);
}

TEST_F(ClothBranch, VertexDistanceIsZeroOnlyForTheSameDrape) {
  EXPECT_EQ(VertexDistance(drape_, drape_), 0.0);
  EXPECT_GT(VertexDistance(drape_, Turned(kTurn)), 0.01);
  Eigen::VectorXd moved = drape_;
  for (int i = 0; i < mesh_.num_vertices(); ++i) moved[3 * i] += 2e-3;
  EXPECT_NEAR(VertexDistance(drape_, moved), 2e-3, 1e-15);
}

TEST_F(ClothBranch, AnOutlineNeedsClothOnEachRay) {
  Eigen::VectorXd outline, aside = drape_;
  for (int i = 0; i < mesh_.num_vertices(); ++i) aside[3 * i] += 1.0;
  EXPECT_FALSE(DrapeOutline(mesh_, aside, &outline));
}

TEST(ClusterByDistance, LinksChains) {
  Eigen::MatrixXd distance = Eigen::MatrixXd::Constant(5, 5, 9.0);
  const auto link = [&](int i, int j) { distance(i, j) = distance(j, i) = 1.0; };
  distance.diagonal().setZero();
  link(0, 3);
  link(3, 2);
  using testing::ElementsAre;
  EXPECT_THAT(ClusterByDistance(distance, 1.0),
              ElementsAre(ElementsAre(0, 2, 3), ElementsAre(1), ElementsAre(4)));
  EXPECT_EQ(ClusterByDistance(distance, 0.5).size(), 5u);
  EXPECT_TRUE(ClusterByDistance(Eigen::MatrixXd(0, 0), 1.0).empty());
}

}  // namespace
}  // namespace drape
