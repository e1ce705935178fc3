// SPDX-License-Identifier: Apache-2.0
// Derivatives of the whole rollout: the tangent is compared with the adjoint, both with
// differences.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "physics/simulation/rollout.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

constexpr std::size_t kKeepAll = std::size_t{1} << 40;

RolloutOptions ShortRollout(std::size_t factor_memory = kKeepAll) {
  RolloutOptions options;
  options.steps = 10;
  options.factor_memory = factor_memory;
  return options;
}

struct Case {
  std::string law;
  bool scattered;  // a table for each face and hinge
  int kept;        // number of final steps whose factors are kept
};
class AdjointTest : public testing::TestWithParam<Case> {};

// Everything that the derivatives of a rollout need, from a fixed seed.
struct Experiment {
  explicit Experiment(const std::string& law, bool scattered)
      : random(17), model(test::SmallDisc(law)), solver(model), material(test::TestMaterial()) {
    if (scattered) material = test::Scatter(material, model->mesh, 0.3, random);
    start = test::NoisyStart(*model, 1e-3, random);
    start.v = 0.05 * test::RandomMatrix(model->num_dofs(), 1, random);
  }
  std::mt19937_64 random;
  std::shared_ptr<const ClothModel> model;
  StepSolver solver;
  MaterialField material;
  State start;
};

TEST_P(AdjointTest, AgreesWithTangentTo1em10) {
  const Case& c = GetParam();
  Experiment s(c.law, c.scattered);
  const RolloutOptions options = ShortRollout(c.kept * s.solver.linear().factor_bytes());
  // The derivative by the logarithm of all entries at once, column by column.
  const TangentResult tangent = RolloutTangent(s.solver, s.material, s.material, s.start, options);
  Recording recording;
  ASSERT_EQ(Rollout(s.solver, s.material, s.start, options, &recording).status, RolloutStatus::kOk);
  int kept = 0;
  for (const auto& factor : recording.factor) kept += !factor.empty();
  ASSERT_EQ(kept, c.kept);
  const RowMatrix u = test::RandomMatrix(s.model->num_dofs(), 3, s.random);
  const AdjointResult adjoint = RolloutAdjoint(s.solver, s.material, options, recording, u);
  ASSERT_EQ(adjoint.status, RolloutStatus::kOk);
  const RowMatrix by_tangent = tangent.dx.transpose() * u;
  const RowMatrix by_adjoint = adjoint.material.Contract(s.material);
  EXPECT_LT((by_adjoint - by_tangent).norm(), 1e-10 * by_tangent.norm());
  EXPECT_GT(by_tangent.norm(), 0.0);
  // A single gradient takes another path through the element loops than several gradients.
  const AdjointResult first =
      RolloutAdjoint(s.solver, s.material, options, recording, u.leftCols(1));
  EXPECT_LT((first.material.Contract(s.material) - by_adjoint.leftCols(1)).norm(),
            1e-12 * by_adjoint.norm());
  EXPECT_LT((first.x0 - adjoint.x0.leftCols(1)).norm(), 1e-12 * adjoint.x0.norm());
  EXPECT_LT((first.v0 - adjoint.v0.leftCols(1)).norm(), 1e-12 * adjoint.v0.norm());
}

// Along one direction of material and start: ⟨u, J·d⟩ = ⟨Jᵀ·u, d⟩.
TEST_P(AdjointTest, AgreesWithJvpTo1em10) {
  const Case& c = GetParam();
  Experiment s(c.law, c.scattered);
  const RolloutOptions options = ShortRollout();
  const MaterialField change = c.scattered ? test::Scatter(s.material, s.model->mesh, 0.5, s.random)
                                           : test::TestMaterial(0.7);
  const State moved = {test::RandomMatrix(s.model->num_dofs(), 1, s.random),
                       test::RandomMatrix(s.model->num_dofs(), 1, s.random)};
  const JvpResult jvp = RolloutJvp(s.solver, s.material, change, s.start, moved, options);
  Recording recording;
  const RolloutResult end = Rollout(s.solver, s.material, s.start, options, &recording);
  ASSERT_EQ(jvp.rollout.status, RolloutStatus::kOk);
  EXPECT_EQ(jvp.rollout.end.x, end.end.x);
  EXPECT_EQ(jvp.rollout.steps, options.steps);
  const RowMatrix u = test::RandomMatrix(s.model->num_dofs(), 1, s.random);
  const AdjointResult adjoint = RolloutAdjoint(s.solver, s.material, options, recording, u);
  const double by_material = adjoint.material.Contract(change).sum(),
               by_x = adjoint.x0.col(0).dot(moved.x), by_v = adjoint.v0.col(0).dot(moved.v);
  const double expected = by_material + by_x + by_v;
  EXPECT_NEAR(u.col(0).dot(jvp.change.x), expected,
              1e-10 * (std::abs(by_material) + std::abs(by_x) + std::abs(by_v)));
  EXPECT_NE(by_material, 0.0);
  EXPECT_NE(by_v, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Product, AdjointTest,
                         testing::Values(Case{"reference", false, 10}, Case{"reference", true, 10},
                                         Case{"reference", false, 0}, Case{"reference", true, 4},
                                         Case{"smooth", false, 10}, Case{"smooth", true, 10},
                                         Case{"smooth", true, 0}, Case{"smooth", false, 4}),
                         [](const auto& info) {
                           return info.param.law +
                                  (info.param.scattered ? "Field" : "Homogeneous") + "Kept" +
                                  std::to_string(info.param.kept);
                         });

class RolloutDerivativeTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Laws, RolloutDerivativeTest, testing::Values("reference", "smooth"),
                         [](const auto& info) { return info.param; });

// Compares the derivatives of x_end·u by the start with central differences along a random
// direction.
TEST_P(RolloutDerivativeTest, AdjointByTheStart) {
  Experiment s(GetParam(), true);
  const RolloutOptions options = ShortRollout();
  const int n = s.model->num_dofs();
  const RowMatrix u = test::RandomMatrix(n, 1, s.random),
                  direction = test::RandomMatrix(n, 1, s.random);
  Recording recording;
  (void)Rollout(s.solver, s.material, s.start, options, &recording);
  const AdjointResult adjoint = RolloutAdjoint(s.solver, s.material, options, recording, u);
  for (const bool by_velocity : {false, true}) {
    const double exact = (by_velocity ? adjoint.v0 : adjoint.x0).cwiseProduct(direction).sum();
    double best = 1.0;
    for (double step = 1e-5; step > 1e-9; step /= 10) {
      const auto end = [&](double sign) {
        State start = s.start;
        (by_velocity ? start.v : start.x) += sign * step * direction;
        return Rollout(s.solver, s.material, start, options).end.x.dot(u.col(0));
      };
      best = std::min(best, std::fabs((end(1) - end(-1)) / (2 * step) / exact - 1.0));
    }
    EXPECT_LT(best, 1e-6) << (by_velocity ? "v0" : "x0");
  }
}

// The directional derivative along the logarithms of the entries by central differences, for a
// sweep of steps.
double DifferenceError(Experiment& s, const RowMatrix& exact, const Eigen::VectorXd& direction,
                       double step) {
  const auto end = [&](double sign) {
    MaterialField moved = s.material;
    for (StretchTable& table : moved.stretch)
      for (int k = 0; k < kStretchEntries; ++k)
        table.entries()[k] *= std::exp(sign * step * direction[k]);
    for (BendTable& table : moved.bend)
      for (int k = 0; k < kBendEntries; ++k)
        table.entries()[k] *= std::exp(sign * step * direction[kStretchEntries + k]);
    return Rollout(s.solver, moved, s.start, ShortRollout()).end.x;
  };
  const Eigen::VectorXd difference = (end(1) - end(-1)) / (2 * step), expected = exact * direction;
  return (difference - expected).norm() / expected.norm();
}

// Derivatives by the logarithms of the entries, of one table for the whole cloth and of a random
// one for each face and hinge.
TEST_P(RolloutDerivativeTest, TangentAgreesWithFiniteDifferencesOverASweep) {
  for (const bool scattered : {false, true}) {
    Experiment s(GetParam(), scattered);
    const RowMatrix dx =
        RolloutTangent(s.solver, s.material, s.material, s.start, ShortRollout()).dx;
    Eigen::VectorXd direction = test::RandomMatrix(kMaterialEntries, 1, s.random);
    direction /= direction.cwiseAbs().maxCoeff();
    std::printf("%s, %s: relative error of the tangent against central differences\n",
                GetParam().c_str(), scattered ? "a random table for each element" : "one table");
    std::vector<double> errors;
    for (double step = 1e-3; step > 0.5e-8; step /= 10) {
      errors.push_back(DifferenceError(s, dx, direction, step));
      std::printf("  step %.0e in log entries: %.2e\n", step, errors.back());
    }
    EXPECT_LT(*std::min_element(errors.begin(), errors.end()), 1e-6);
    if (GetParam() == "reference") continue;
    // The smooth law has no kink within a typical step of the optimiser: only the truncation error
    // of the differences remains, which decreases with the square of the step.
    EXPECT_LT(errors[0], 1e-3);
    EXPECT_NEAR(errors[0] / errors[1], 100.0, 20.0);
  }
}

// Entry by entry, with the error relative to the derivative of that entry, at the best step of the
// sweep.
TEST_P(RolloutDerivativeTest, EachEntryAgreesWithFiniteDifferences) {
  Experiment s(GetParam(), false);
  const RowMatrix dx = RolloutTangent(s.solver, s.material, s.material, s.start, ShortRollout()).dx;
  int reached = 0;
  for (int k = 0; k < kMaterialEntries; ++k) {
    if (dx.col(k).norm() < 1e-9 * dx.norm())
      continue;  // curvatures that do not occur in this cloth
    ++reached;
    double best = 1.0;
    for (const double step : {1e-3, 1e-4, 1e-5})
      best =
          std::min(best, DifferenceError(s, dx, Eigen::VectorXd::Unit(kMaterialEntries, k), step));
    EXPECT_LT(best, 1e-6) << "entry " << k << ", |dx| " << dx.col(k).norm();
  }
  EXPECT_GE(reached, 24);
}

}  // namespace
}  // namespace drape
