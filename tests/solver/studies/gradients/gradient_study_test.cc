// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_study.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/rollout.h"
#include "solver/forward/random_drapes.h"
#include "tests/physics/cloth_fixture.h"
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

namespace drape::test {
namespace {

const Eigen::VectorXd kStretch = Eigen::Vector2d(1, 0), kBend = Eigen::Vector2d(0, 1);

double LargestDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return (a - b).reshaped(3, a.size() / 3).colwise().norm().maxCoeff();
}

class FollowDrape : public testing::Test {
 protected:
  FollowDrape() {
    const State start = {ApplyStartShape(model_->mesh, 0.09, RandomStartShape(6, 5e-3)),
                         Eigen::VectorXd::Zero(model_->num_dofs())};
    RolloutOptions steps;
    steps.h = 0.1;
    fallen_ = Rollout(solver_, TestMaterial(), start, steps).end.x;
  }
  ContinuationResult Follow(const Eigen::VectorXd& direction, const ContinuationOptions& options) {
    return FollowBranch(solver_, parametrisation_, direction, fallen_, options);
  }
  EquilibriumResult Direct(const Eigen::VectorXd& direction, double s, const Eigen::VectorXd& x) {
    return SolveEquilibrium(solver_, parametrisation_.Material(s * direction), x, {});
  }

  const std::shared_ptr<const ClothModel> model_ = SmallDisc("smooth", 200);
  const TableParametrisation parametrisation_{TestMaterial(), ParameterTying::kScales};
  StepSolver solver_{model_};
  Eigen::VectorXd fallen_;
};

TEST_F(FollowDrape, ASmoothPathMeetsTheDirectSolves) {
  for (const Eigen::VectorXd& direction : {kStretch, kBend}) {
    ContinuationOptions options;
    options.end = 0.1;
    const ContinuationResult path = Follow(direction, options);
    ASSERT_EQ(path.status, ContinuationStatus::kReachedEnd);
    ASSERT_GE(path.points.size(), 3u);
    EXPECT_EQ(path.points.front().s, 0.0);
    EXPECT_EQ(path.points.back().s, options.end);
    for (size_t i = 1; i < path.points.size(); ++i) {
      const ContinuationPoint& point = path.points[i];
      EXPECT_LE(point.prediction_error, options.max_error);
      EXPECT_GT(point.stiffness, 0.0);
      const EquilibriumResult direct = Direct(direction, point.s, path.points[i - 1].x);
      EXPECT_EQ(direct.status, EquilibriumStatus::kStable);
      EXPECT_LT(LargestDistance(direct.x, point.x), 1e-6);
    }
  }
}

TEST_F(FollowDrape, SpeedIsTheDerivativeOfThePath) {
  ContinuationOptions options;
  options.end = options.first_step = options.min_step = 1e-4;
  const ContinuationResult path = Follow(kBend, options);
  ASSERT_EQ(path.points.size(), 2u);
  const double difference = VertexDistance(path.points[0].x, path.points[1].x) / options.end;
  EXPECT_NEAR(path.points[0].speed / difference, 1.0, 1e-2);
}

TEST_F(FollowDrape, AStepIsTakenBackWhenThePredictionFails) {
  ContinuationOptions options;
  options.end = -0.1;
  options.first_step = options.max_step = 0.1;
  options.max_error = 1e-4;
  options.min_step = 1e-3;
  const ContinuationResult path = Follow(kBend, options);
  EXPECT_GT(path.refused, 0);
  for (const ContinuationPoint& point : path.points)
    EXPECT_LE(point.prediction_error, options.max_error);
}

TEST_F(FollowDrape, ABranchThatEndsIsReported) {
  ContinuationOptions options;
  options.end = -3.0;
  const ContinuationResult path = Follow(kBend, options);
  ASSERT_EQ(path.status, ContinuationStatus::kFold);
  const ContinuationPoint &last = path.points.back(), &first = path.points.front();
  EXPECT_LT(path.lost_at, last.s);
  EXPECT_GT(path.lost_at, last.s - 2 * options.min_step);
  EXPECT_GT(path.refused, 3);
  EXPECT_GT(last.speed, 2 * first.speed);
  EXPECT_LT(last.stiffness, 0.2 * first.stiffness);
  ASSERT_TRUE(path.fold_estimate.has_value());
  EXPECT_NEAR(*path.fold_estimate, path.lost_at, 5 * options.min_step);
  // Beyond it Newton finds no drape near the last one.
  const EquilibriumResult beyond = Direct(kBend, path.lost_at - 0.05, last.x);
  EXPECT_TRUE(beyond.status != EquilibriumStatus::kStable ||
              LargestDistance(beyond.x, last.x) > options.max_error);
}

TEST_F(FollowDrape, APathWithoutAStartHasNoPoints) {
  ContinuationOptions options;
  options.corrector.max_iterations = 0;
  EXPECT_EQ(Follow(kBend, options).status, ContinuationStatus::kNoStart);
  EXPECT_TRUE(Follow(kBend, options).points.empty());
  const std::atomic<bool> cancel = true;
  options.corrector.cancel = &cancel;
  EXPECT_EQ(Follow(kBend, options).status, ContinuationStatus::kCancelled);
}

// An upright strip, clamped at its lower end, buckles under its own weight at ρ·g·L³/D = 7.837
// (Greenhill 1881); D of a narrow strip: mesh_spec.h.
TEST(FollowStrip, FindsTheBucklingLoadOfAStandingStrip) {
  constexpr double kLength = 0.12, kClamped = 0.09, kWidth = 0.02, kGravity = 9.8;
  constexpr int kAlong = 42, kAcross = 5;
  Scene scene;
  scene.gravity = Eigen::Vector3d(-kGravity, 0, 0);
  Handles handles;  // of radius 0.09
  handles.stiffness = 1e6;
  scene.handles = handles;
  const auto model = std::make_shared<ClothModel>(
      MakeStrip(kClamped + kLength, kWidth, kAlong, kAcross), scene, MakeLaw("smooth"));
  MaterialField material;
  material.density = 0.2;
  material.stretch.resize(1);
  for (auto& row : material.stretch[0].c) row[0] = row[2] = 2 * (row[3] = 1e3);
  material.bend.resize(1);
  const double rigidity = 1e-3;
  for (auto& row : material.bend[0].b)
    for (double& entry : row) entry = kBendPerRigidity * rigidity;

  StepSolver solver(model);
  ContinuationOptions options;
  options.end = -2.0;
  options.first_step = 0.1;
  options.corrector.tolerance = 1e-7;  // the stiff clamp rounds the force
  const ContinuationResult path =
      FollowBranch(solver, TableParametrisation(material, ParameterTying::kScales), kBend,
                   model->mesh.rest_x, options);
  ASSERT_EQ(path.status, ContinuationStatus::kFold);
  // Between a narrow strip's D·(1 − ν²), free to curl across, and the plate's D.
  const double plate =
      std::log(material.density * kGravity * std::pow(kLength, 3) / 7.837 / rigidity);
  EXPECT_GT(path.lost_at, plate);
  EXPECT_LT(path.lost_at, plate - std::log((1 - 1.0 / 9) * (1 - 1.0 / (9 * kAcross))));
  EXPECT_LT(path.points.back().s - path.lost_at, 2 * options.min_step);
  EXPECT_LT(path.points.back().stiffness, 1e-2 * path.points.front().stiffness);
}

}  // namespace
}  // namespace drape::test
