// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

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
