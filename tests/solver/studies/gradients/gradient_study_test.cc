// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// x = (s* − s)^½ at s* = 0.3: the speed is ½(s* − s)^−½ and λ₁ grows as (s* − s)^½.
TEST(GradientStudy, AFoldHasItsExponents) {
  ContinuationResult path;
  path.status = ContinuationStatus::kFold;
  for (const double s : {0.0, 0.25, 0.29, 0.298, 0.2999}) {
    ContinuationPoint point;
    point.s = s;
    point.speed = 0.5 / std::sqrt(0.3 - s);
    point.stiffness = 40 * std::sqrt(0.3 - s);
    path.points.push_back(point);
  }
  path.fold_estimate = 0.3;
  const auto approach = FindFoldApproach(path, 12.0);
  ASSERT_TRUE(approach);
  EXPECT_EQ(approach->speed.size(), 3u);  // within a twelfth of the largest speed
  EXPECT_NEAR(approach->speed_by_distance->exponent, -0.5, 1e-9);
  EXPECT_NEAR(approach->speed_by_stiffness->exponent, -1.0, 1e-9);
  path.status = ContinuationStatus::kReachedEnd;
  EXPECT_FALSE(FindFoldApproach(path, 12.0));
}

// The tangent is the limit of the differences: their error falls with the square of the step.
TEST(GradientStudy, DifferencesMeetTheTangent) {
  const auto backend = test::SmoothDisc(100);
  const TableParametrisation line(test::TestMaterial(),
                                  Eigen::MatrixXd::Constant(kMaterialEntries, 1, 0.2));
  const State start = test::RandomStart(backend->model(), 3);
  const std::array<double, 2> steps = {1e-3, 1e-5};
  const auto errors = CompareDifferences(*backend, line, start, SolveMode::kDynamic,
                                         {.h = 0.05, .steps = 4}, steps);
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_GT(errors[0].size, 0.0);
  EXPECT_LT(errors[0].error, 1e-3);
  EXPECT_LT(errors[1].error, 1e-6);
}

}  // namespace
}  // namespace drape
