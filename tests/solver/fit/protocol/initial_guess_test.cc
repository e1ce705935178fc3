// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/initial_guess.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/statics.h"
#include "solver/fit/rollout_residuals.h"
#include "tests/solver/fake_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kGuessAngles = 90;

TEST(Scaled, MultipliesStretchAndBendApart) {
  const MaterialField base = test::TestMaterial(), scaled = Scaled(base, 4.0, 0.5);
  EXPECT_EQ(scaled.density, base.density);
  for (int i = 0; i < kStretchEntries; ++i)
    EXPECT_EQ(scaled.stretch[0].entries()[i], 4.0 * base.stretch[0].entries()[i]) << i;
  for (int i = 0; i < kBendEntries; ++i)
    EXPECT_EQ(scaled.bend[0].entries()[i], 0.5 * base.bend[0].entries()[i]) << i;
}

double LowestVertex(const State& state) {
  return state.x.reshaped(3, state.x.size() / 3).row(2).minCoeff();
}

TEST(StartAt, HangsUnderTheOutlineOutsideTheSupport) {
  const auto model = test::SmallDisc("smooth", 300);
  Observation observation;
  observation.radius = Eigen::VectorXd::Constant(kGuessAngles, 0.12 * observation.camera.scale);
  const State seed = StartAt(*observation.Measured(), *model, 1.0);
  EXPECT_EQ(seed.v, Eigen::VectorXd::Zero(model->num_dofs()));
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(model->mesh, seed.x, observation.camera, kGuessAngles, &outline));
  EXPECT_LT((outline.radius - observation.radius).cwiseAbs().maxCoeff(), 0.5);
  for (const int held : model->held)
    EXPECT_LT((seed.x - model->mesh.rest_x).segment<3>(3 * held).norm(), 1e-15) << held;
  // A flap of 6 cm that reaches out by 3 cm hangs 6 cm · sin 60° low.
  EXPECT_NEAR(LowestVertex(seed), -0.06 * std::sin(M_PI / 3), 1e-4);
  EXPECT_NEAR(LowestVertex(StartAt(*observation.Measured(), *model, 0.5)),
              -0.06 * std::sin(M_PI / 6), 1e-4);
}

std::vector<InitialGuess> RankInitialGuesses(Backend& coarse, const MaterialField& table,
                                             const std::vector<Observation>& observations,
                                             const InitialGuessOptions& options,
                                             const RunControl& control) {
  TriedGuesses tried;
  TryInitialGuesses(coarse, {table}, observations, options, control, tried, [] {});
  return RankGuesses(tried);
}

TEST(RankGuesses, PutsTheTrueScalesFirst) {
  const auto backend = test::SmoothDisc(150);
  const MaterialField base = test::TestMaterial(), reference = Scaled(base, 1.0, 4.0);
  InitialGuessOptions options;
  options.stretch = {1.0};
  options.bend = {0.25, 1.0, 4.0, 16.0};
  options.lifts = {0.6, 1.0};
  const State drape = test::Settled(*backend, reference, test::RandomStart(backend->model(), 1));
  const std::vector<Observation> observations = {
      test::MakeObservation(backend->model().mesh, drape, kGuessAngles, "reference")};
  double last = 0.0;
  const auto ranked = RankInitialGuesses(*backend, base, observations, options,
                                         {.progress = [&](double share, const std::string&) {
                                           EXPECT_GT(share, last);
                                           last = share;
                                         }});
  EXPECT_EQ(last, 1.0);
  ASSERT_EQ(ranked.size(), 8);
  EXPECT_EQ(ranked[0].stretch, 1.0);
  EXPECT_EQ(ranked[0].bend, 4.0);
  EXPECT_LT(ranked[0].profile_rms, 2.0);
  for (std::size_t i = 1; i < ranked.size(); ++i)
    EXPECT_LE(ranked[i - 1].profile_rms, ranked[i].profile_rms);
}

// Without physics: the drape is known for each material.
class InitialGuessTest : public testing::Test {
 protected:
  InitialGuessTest() {
    options_.stretch = {0.5, 1.0, 2.0};
    options_.bend = {0.5, 1.0};
    options_.lifts = {0.5, 1.0};
  }
  Observation MakeObservation(double stretch, double bend) const {
    return test::ObserveDrape(backend_, Scaled(test::TestMaterial(), stretch, bend), kGuessAngles);
  }
  std::vector<InitialGuess> Rank(const std::vector<Observation>& observations,
                                 const std::atomic<bool>* cancel = nullptr) {
    return RankInitialGuesses(backend_, test::TestMaterial(), observations, options_,
                              {.cancel = cancel});
  }
  test::FakeBackend backend_;
  InitialGuessOptions options_;
};

TEST_F(InitialGuessTest, RanksByTheOutline) {
  const auto ranked = Rank({MakeObservation(2.0, 0.5)});
  ASSERT_EQ(ranked.size(), 12);
  EXPECT_EQ(ranked[0].stretch, 2.0);
  EXPECT_EQ(ranked[0].bend, 0.5);
  EXPECT_LT(ranked[0].profile_rms, 1e-9);
  EXPECT_GT(ranked[2].profile_rms, 0.1);
}

TEST_F(InitialGuessTest, FailedTrialsAreLeftOut) {
  backend_.fails = [](double s, double) { return s > 0.1; };
  const auto ranked = Rank({MakeObservation(2.0, 0.5)});
  EXPECT_EQ(ranked.size(), 8);
  for (const InitialGuess& candidate : ranked) EXPECT_LE(candidate.stretch, 1.0);
  backend_.fails = [](double, double) { return true; };
  EXPECT_TRUE(Rank({MakeObservation(2.0, 0.5)}).empty());
}

TEST_F(InitialGuessTest, SeveralTargetsShareOneScale) {
  const Observation a = MakeObservation(2.0, 0.5), b = MakeObservation(0.5, 0.5);
  const auto alone = Rank({a}), both = Rank({a, b});
  ASSERT_EQ(both.size(), 12);
  EXPECT_EQ(both[0].stretch, 1.0);  // between the two
  ASSERT_EQ(both[0].lifts.size(), 2);
  const auto rms_of = [](const std::vector<InitialGuess>& ranked, double stretch) {
    return std::find_if(ranked.begin(), ranked.end(),
                        [&](const InitialGuess& candidate) {
                          return candidate.stretch == stretch && candidate.bend == 0.5;
                        })
        ->profile_rms;
  };
  // Root mean square over the two observations.
  const auto other = Rank({b});
  EXPECT_NEAR(rms_of(both, 1.0),
              std::hypot(rms_of(alone, 1.0), rms_of(other, 1.0)) / std::sqrt(2.0), 1e-12);
}

TEST_F(InitialGuessTest, ACancelEndsIt) {
  const std::atomic<bool> cancel = true;
  EXPECT_TRUE(Rank({MakeObservation(2.0, 0.5)}, &cancel).empty());
}

}  // namespace
}  // namespace drape
