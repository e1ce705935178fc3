// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "losses/outline/measured_image.h"

namespace drape {
namespace {

using std::numbers::pi;

constexpr int kAngles = 360;
constexpr double kTurn = 2 * pi * 25 / kAngles;

// Folds of one order on a weaker wave that distinguishes left from right.
Eigen::VectorXd Folded(int folds, double phase) {
  Eigen::VectorXd r(kAngles);
  for (int i = 0; i < kAngles; ++i) {
    const double t = 2 * pi * i / kAngles - phase;
    r[i] = .11 + .01 * std::cos(folds * t) + .004 * std::sin(2 * t);
  }
  return r;
}

Eigen::VectorXd Mirror(const Eigen::VectorXd& r) {
  Eigen::VectorXd result = r;
  for (Eigen::Index i = 1; i < r.size(); ++i) result[i] = r[r.size() - i];
  return result;
}

TEST(MatchOutlines, FindsTheSameOutline) {
  const Eigen::VectorXd r = Folded(5, 1);
  for (const auto freedom :
       {OutlineFreedom::kFixed, OutlineFreedom::kRotation, OutlineFreedom::kRotationAndMirror}) {
    const OutlineMatch match = MatchOutlines(r, r, freedom);
    EXPECT_EQ(match.rms, 0.0);
    EXPECT_EQ(match.rotation, 0.0);
    EXPECT_FALSE(match.mirrored);
  }
}

TEST(MatchOutlines, FindsTheRotationOfB) {
  const Eigen::VectorXd a = Folded(5, 1 + kTurn), b = Folded(5, 1);
  EXPECT_GT(MatchOutlines(a, b).rms, 5e-3);
  const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotation);
  EXPECT_LT(match.rms, 1e-14);
  EXPECT_NEAR(match.rotation, kTurn, 1e-12);
}

TEST(MatchOutlines, FindsTheMirrorImageOnlyWhenAsked) {
  const Eigen::VectorXd a = Folded(5, 1), b = Mirror(Folded(5, 1 - kTurn));
  EXPECT_GT(MatchOutlines(a, b, OutlineFreedom::kRotation).rms, 1e-3);
  const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotationAndMirror);
  EXPECT_LT(match.rms, 1e-14);
  EXPECT_TRUE(match.mirrored);
  EXPECT_NEAR(match.rotation, kTurn, 1e-12);
}

TEST(RefineRotation, FindsARotationBetweenTheAngles) {
  for (const double part : {-0.4, 0.0, 0.3}) {
    for (const bool mirrored : {false, true}) {
      const double turn = kTurn + part * 2 * pi / kAngles;
      const Eigen::VectorXd a = Folded(5, 1 + turn);
      const Eigen::VectorXd b = mirrored ? Mirror(Folded(5, 1)) : Folded(5, 1);
      const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotationAndMirror);
      EXPECT_NEAR(match.rotation, kTurn, 1e-12);
      const OutlineMatch refined = RefineRotation(a, b, match);
      EXPECT_NEAR(refined.rotation, turn, 1e-5);
      EXPECT_EQ(refined.mirrored, mirrored);
    }
  }
}

}  // namespace
}  // namespace drape
