// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/performance_profile.h"

#include <gtest/gtest.h>

#include <limits>

namespace drape {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

TEST(PerformanceProfile, WhatATraceSpentToReachACost) {
  const std::vector<TracePoint> trace = {{1, 0.1, 100}, {4, 0.3, 20}, {9, 2.0, 5}};
  EXPECT_EQ(SpentToReach(trace, 100, BudgetUnit::kBudget), 1);
  EXPECT_EQ(SpentToReach(trace, 20, BudgetUnit::kBudget), 4);
  EXPECT_EQ(SpentToReach(trace, 19, BudgetUnit::kSeconds), 2.0);
  EXPECT_EQ(SpentToReach(trace, 4, BudgetUnit::kBudget), kNever);
  EXPECT_EQ(SpentToReach({}, 4, BudgetUnit::kBudget), kNever);
  EXPECT_DOUBLE_EQ(SolvedBelow(100, 20, 0.1), 28);
}

TEST(PerformanceProfile, RatiosAreToTheBestOfEachProblem) {
  Eigen::MatrixXd spent(3, 2);
  spent << 10, 40, kNever, 7, kNever, kNever;
  const Eigen::MatrixXd ratios = PerformanceRatios(spent);
  EXPECT_EQ(ratios(0, 0), 1);
  EXPECT_EQ(ratios(0, 1), 4);
  EXPECT_EQ(ratios(1, 0), kNever);
  EXPECT_EQ(ratios(1, 1), 1);
  EXPECT_EQ(ratios(2, 1), kNever);
  EXPECT_NEAR(ProfileAt(ratios.col(0), 1), 1.0 / 3, 1e-15);
  EXPECT_NEAR(ProfileAt(ratios.col(1), 3.9), 1.0 / 3, 1e-15);
  EXPECT_NEAR(ProfileAt(ratios.col(1), 4), 2.0 / 3, 1e-15);
}

TEST(PerformanceProfile, TheStaircaseBeginsAtTheBestAndEndsAtTheShareSolved) {
  Eigen::VectorXd ratios(5);
  ratios << 2, 1, kNever, 2, 8;
  const std::vector<ProfileStep> steps = ProfileSteps(ratios);
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_EQ(steps[0].factor, 1);
  EXPECT_DOUBLE_EQ(steps[0].share, 0.2);
  EXPECT_DOUBLE_EQ(steps[1].share, 0.6);
  EXPECT_EQ(steps[2].factor, 8);
  EXPECT_DOUBLE_EQ(steps[2].share, 0.8);
  EXPECT_EQ(ProfileSteps(Eigen::VectorXd::Constant(2, kNever)).front().share, 0);
}

}  // namespace
}  // namespace drape
