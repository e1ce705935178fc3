// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/guided_settle.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdio>

#include "losses/readout/place_readouts.h"
#include "physics/material/material_scaling.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/fit/rollout_residuals.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// On bend: some folds, as of a fabric.
constexpr double kSoft = 0.1;

// The heights of all vertices, as a camera above sees them.
struct HeightReadout final : Readout {
  explicit HeightReadout(int vertices) : vertices(vertices) {}
  int size() const override { return vertices; }
  bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const override {
    *r = x.reshaped(3, vertices).row(2).transpose();
    if (dr_dx == nullptr) return true;
    dr_dx->resize(vertices, x.size());
    for (int v = 0; v < vertices; ++v) dr_dx->insert(v, 3 * v + 2) = 1.0;
    return true;
  }
  const int vertices;
};

class GuidedDrapeTest : public testing::Test {
 protected:
  GuidedDrapeTest() {
    settle_.steps = {.h = 0.1, .steps = 60};
    settle_.equilibrium.max_iterations = 60;
  }
  // A drape of the material as an image has it.
  Observation Observe(const State& start) {
    const State drape = test::Settled(*backend_, material_, start);
    return test::MakeObservation(backend_->model().mesh, drape, 90, "reference");
  }
  State RandomStart(int seed) const { return test::RandomStart(backend_->model(), seed, 2e-2); }
  // The heights of all vertices of a drape as an experiment.
  Observation MeasureHeights(const State& drape) const {
    const ClothModel& model = backend_->model();
    const auto readout = std::make_shared<HeightReadout>(model.mesh.num_vertices());
    Measurement heights{
        .name = "heights", .readout = [=](const ClothModel&) { return readout; }, .sigma = 2e-3};
    EXPECT_TRUE(readout->Read(drape.x, &heights.data, nullptr));
    Observation observation;
    observation.experiment =
        std::make_shared<const Experiment>(Experiment{.name = "cloth",
                                                      .mesh = model.mesh,
                                                      .scene = model.scene,
                                                      .measurements = {heights},
                                                      .random_starts = 8});
    return observation;
  }
  double Rms(const SettledDrape& drape, const Observation& observation) const {
    return Misfit(*observation.Measured(), backend_->model(), material_, drape.rest.x).value();
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(200);
  const MaterialField material_ = Scaled(test::TestMaterial(), 1.0, kSoft);
  SettleOptions settle_;
};

// The hem goes as far as the outline is away, along its normal; what is held stays, and between
// them the displacement is harmonic.
TEST_F(GuidedDrapeTest, ThePullIsTheDistanceToTheOutline) {
  const ClothModel& model = backend_->model();
  const Eigen::VectorXd flat = model.RestState().x;
  Observation observation = test::MakeObservation(model.mesh, model.RestState(), 360, "flat");
  const auto pull = [&] {
    return DisplacementTo(model, MakeSights(*observation.Measured(), model).front(), flat);
  };
  EXPECT_LT(pull().cwiseAbs().maxCoeff(), 1e-4);  // but for the pixels of the image
  constexpr double kFurther = 0.01;               // [m]
  observation.radius.array() += kFurther * observation.outline_camera().pixels_per_metre();
  const Eigen::VectorXd displacement = pull();
  const double held = DrapeDiscs().support, hem = 0.15;
  for (int v = 0; v < model.mesh.num_vertices(); ++v) {
    const Eigen::Vector2d p = model.mesh.uv.col(v);
    const double share = std::max(0.0, std::log(p.norm() / held) / std::log(hem / held));
    const double tolerance = share > 0.99 || share == 0.0 ? 0.02 : 0.15;  // the rings are coarse
    const Eigen::Vector3d d = displacement.segment<3>(3 * v);
    EXPECT_NEAR(d.head<2>().dot(p.normalized()), share * kFurther, tolerance * kFurther) << v;
    EXPECT_NEAR(d.z(), 0.0, 1e-12);
  }
}

// Markers pull their vertices to where they were seen, but each number at most 5 cm.
TEST_F(GuidedDrapeTest, ThePullOfMarkersIsTheirDistance) {
  const ClothModel& model = backend_->model();
  const Eigen::VectorXd flat = model.RestState().x;
  Eigen::VectorXd away = Eigen::VectorXd::Random(flat.size()) * 0.03;
  away[0] = 0.2;
  const Sight sight{.readouts = {std::make_shared<PositionReadout>(model.mesh)},
                    .data = flat + away};
  away[0] = 0.05;
  EXPECT_LT((DisplacementTo(model, sight, flat) - away).cwiseAbs().maxCoeff(), 1e-12);
}

// From the start shapes of a fit it finds drapes that are nearer to the image than those that the
// same steps find without the pull. They are at rest, without any pull.
TEST_F(GuidedDrapeTest, FindsADrapeNearTheImage) {
  double guided_sum = 0.0, free_sum = 0.0;
  for (const int seed : {1, 2, 3, 4}) {
    const Observation observation = Observe(test::RandomStart(backend_->model(), seed, 2e-2));
    for (const double lift : {0.6, 0.8, 1.0}) {
      const State start = StartAt(*observation.Measured(), backend_->model(), lift);
      const SettledDrape guided = SettleGuided(*backend_, material_, start, observation, settle_);
      const SettledDrape free =
          std::move(Settle(*backend_, material_, {&start, 1}, settle_).front());
      ASSERT_TRUE(guided.IsUsable(settle_.solve_mode) && free.IsUsable(settle_.solve_mode));
      EXPECT_LT(ForceResidual(backend_->model(), material_, guided.rest.x), kAtRestResidual);
      guided_sum += Rms(guided, observation);
      free_sum += Rms(free, observation);
    }
  }
  std::printf("mean distance: guided %.2f px, free %.2f px\n", guided_sum / 12, free_sum / 12);
  EXPECT_LT(guided_sum, 0.97 * free_sum);
}

// From random waves it comes nearer to what another cloth of the fabric shows.
TEST_F(GuidedDrapeTest, FindsADrapeNearWhatAnExperimentSees) {
  double guided_sum = 0.0, free_sum = 0.0;
  for (const int seed : {11, 12, 13, 14}) {
    const Observation observation =
        MeasureHeights(test::Settled(*backend_, material_, RandomStart(seed)));
    for (const int start : {1, 2, 3}) {
      const State from = MakeStart(*observation.experiment, backend_->model(), start);
      guided_sum +=
          Rms(SettleGuided(*backend_, material_, from, observation, settle_), observation);
      free_sum += Rms(Settle(*backend_, material_, {&from, 1}, settle_).front(), observation);
    }
  }
  std::printf("mean misfit: guided %.2f sigma, free %.2f sigma\n", guided_sum / 12, free_sum / 12);
  EXPECT_LT(guided_sum, 0.85 * free_sum);
}

// From a drape of another branch, a fit that is pulled ends nearer to what was measured; its cost
// never grows.
TEST_F(GuidedDrapeTest, AFitGoesOnFromANearerBranch) {
  StagedFitOptions options;
  options.parameters = ParameterTying::kScales;
  options.candidates_per_round = {1, 1};
  options.iterations = {5, 5};
  double before_sum = 0.0, after_sum = 0.0;
  for (const int seed : {11, 12, 13, 14}) {
    const Observation heights =
        MeasureHeights(test::Settled(*backend_, material_, RandomStart(seed)));
    const FitProblem problem{.fine = backend_.get(),
                             .coarse = backend_.get(),
                             .material = material_,
                             .observations = {heights},
                             .mirrors = false};
    const CandidateFitter fitter(problem, options, *backend_, nullptr, 1);
    CandidateTask task;
    task.candidate.guess.lifts = {1.0};
    task.candidate.base = material_;
    task.candidate.theta = Eigen::VectorXd::Zero(2);
    task.candidate.shapes = {test::Settled(*backend_, material_, RandomStart(seed + 10)).x};
    fitter.Fit(task, [](double) {});
    ASSERT_TRUE(task.candidate.valid());
    const double cost = task.candidate.cost;
    before_sum += task.candidate.profile_rms;
    const bool is_nearer = fitter.FitNearer(task);
    EXPECT_EQ(is_nearer, task.candidate.cost < cost);
    if (is_nearer) fitter.FitNearer(task);
    EXPECT_LE(task.candidate.cost, cost);
    after_sum += task.candidate.profile_rms;
  }
  std::printf("mean misfit: fitted %.2f sigma, pulled %.2f sigma\n", before_sum / 4, after_sum / 4);
  EXPECT_LT(after_sum, 0.85 * before_sum);
}

TEST_F(GuidedDrapeTest, AFailedStepIsAStatus) {
  std::atomic<bool> cancel = true;
  settle_.steps.cancel = &cancel;
  const Observation observation = Observe(test::RandomStart(backend_->model(), 1));
  const SettledDrape drape = SettleGuided(
      *backend_, material_, test::RandomStart(backend_->model(), 2), observation, settle_);
  EXPECT_EQ(drape.steps, RolloutStatus::kCancelled);
  EXPECT_FALSE(drape.IsUsable(settle_.solve_mode));
}

}  // namespace
}  // namespace drape
