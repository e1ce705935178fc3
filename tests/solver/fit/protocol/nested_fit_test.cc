// SPDX-License-Identifier: Apache-2.0
// More numbers never fit worse: a model starts also from the fit by the one that it contains.
#include "solver/fit/protocol/nested_fit.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>

#include "solver/fit/protocol/candidate_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "tests/solver/fake_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

const TableModel kIsotropic{TableForm::kIsotropic, ParameterTying::kScales};
const TableModel kLinear{TableForm::kLinear, ParameterTying::kColumns};
const TableModel kColumns{TableForm::kGiven, ParameterTying::kColumns};
const TableModel kHomogeneous{TableForm::kGiven, ParameterTying::kEntries};

TEST(SimplerModels, AreThoseThatAModelContains) {
  EXPECT_EQ(SimplerModels(kIsotropic).size(), 0u);
  EXPECT_EQ(SimplerModels(kLinear).size(), 1u);
  EXPECT_EQ(SimplerModels(kColumns).size(), 2u);
  const std::vector<TableModel> all = SimplerModels(kHomogeneous);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(NameFor(all[0]), "isotropic, 2 numbers");
  EXPECT_EQ(NameFor(all[1]), "linear, 7 numbers");
  EXPECT_EQ(NameFor(all[2]), "nonlinear, 7 numbers");
  EXPECT_TRUE(SimplerModels({TableForm::kGiven, ParameterTying::kBendRows}).empty());
  EXPECT_TRUE(SimplerModels({TableForm::kLinear, ParameterTying::kScales}).empty());
}

// A form taken twice is the form, to the bit: the fit of a simpler model is the same as a start and
// on its own.
TEST(SimplerModels, FormsContainOneAnotherToTheBit) {
  const MaterialField given = test::TestMaterial();
  const auto same = [](const MaterialField& a, const MaterialField& b) {
    return std::equal(a.stretch[0].entries(), a.stretch[0].entries() + kStretchEntries,
                      b.stretch[0].entries()) &&
           std::equal(a.bend[0].entries(), a.bend[0].entries() + kBendEntries, b.bend[0].entries());
  };
  const MaterialField linear = InForm(given, TableForm::kLinear);
  EXPECT_TRUE(same(InForm(linear, TableForm::kLinear), linear));
  EXPECT_TRUE(same(InForm(linear, TableForm::kIsotropic), InForm(given, TableForm::kIsotropic)));
}

// A small stiff cloth of isotropic tables, which the grid has: other models have few iterations to
// come as near.
class NestedFitTest : public testing::Test {
 protected:
  NestedFitTest() {
    options_.grid.stretch = {1.0};
    options_.grid.bend = {3.0, 8.0};
    options_.grid.lifts = {1.0};
    options_.grid.steps = 30;
    options_.candidates_per_round = {2, 1};
    options_.iterations = {1, 1};
    problem_.fine = fine_.get();
    problem_.coarse = coarse_.get();
    problem_.material = test::TestMaterial();
    const MaterialField reference =
        Scaled(InForm(test::TestMaterial(), TableForm::kIsotropic), 1.0, 8.0);
    const State drape = test::Settled(*fine_, reference, test::RandomStart(fine_->model(), 1));
    problem_.observations = {test::MakeObservation(fine_->model().mesh, drape, 72, "reference")};
  }
  // As drape_fit runs one of them.
  StagedFitState Run(const TableModel& model) {
    FitProblem problem = problem_;
    problem.material = InForm(problem.material, model.form);
    problem.simpler_models = SimplerModels(model);
    options_.parameters = model.parameters;
    return RunNestedFit(problem, options_, {}, {});
  }

  const std::unique_ptr<Backend> fine_ = test::SmoothDisc(150), coarse_ = test::SmoothDisc(100);
  FitProblem problem_;
  StagedFitOptions options_;
};

TEST_F(NestedFitTest, MoreNumbersNeverFitWorse) {
  double last = std::numeric_limits<double>::infinity();
  for (const TableModel& model : {kIsotropic, kLinear, kColumns, kHomogeneous}) {
    const StagedFitState state = Run(model);
    const FitCandidate* best = Best(state);
    ASSERT_NE(best, nullptr) << NameFor(model);
    std::printf("%s: cost %.4f, %.3f px, %d results before\n", NameFor(model).c_str(), best->cost,
                best->profile_rms, int(state.simpler_results.size()));
    EXPECT_LE(best->cost, last) << NameFor(model);
    EXPECT_EQ(state.simpler_results.size(), SimplerModels(model).size());
    for (const ModelResult& simpler : state.simpler_results)
      EXPECT_LE(best->cost, simpler.cost) << NameFor(model);
    EXPECT_LT(ForceResidual(fine_->model(), FittedMaterial(options_, *best), best->shapes[0]),
              1e-8);
    last = best->cost;
  }
}

// Else the test above shows nothing.
TEST_F(NestedFitTest, OnTheirOwnMoreNumbersFitWorseHere) {
  options_.parameters = ParameterTying::kScales;
  problem_.material = InForm(test::TestMaterial(), TableForm::kIsotropic);
  const double isotropic = Best(RunStagedFit(problem_, options_, {}, {}))->cost;
  options_.parameters = ParameterTying::kEntries;
  problem_.material = test::TestMaterial();
  EXPECT_GT(Best(RunStagedFit(problem_, options_, {}, {}))->cost, isotropic);
}

// Without physics.
class NestedStateTest : public testing::Test {
 protected:
  NestedStateTest() {
    fit_.options.residuals.solve_mode = SolveMode::kStatic;
    fit_.options.parameters = ParameterTying::kEntries;
    fit_.problem.simpler_models = SimplerModels(kHomogeneous);
    control_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
  }
  StagedFitState Run(const StagedFitState& from = {}) {
    return RunNestedFit(fit_.problem, fit_.options, from, control_);
  }

  test::FakeFit fit_;
  StagedFitControl control_;
  std::vector<StagedFitState> saved_;
};

TEST_F(NestedStateTest, GoesOnFromEachSavedStateToTheSameAnswer) {
  const StagedFitState whole = Run();
  const std::vector<StagedFitState> saved = saved_;
  ASSERT_GT(saved.size(), 12u);
  for (std::size_t i = 0; i < saved.size(); ++i) {
    const StagedFitState resumed = Run(saved[i]);
    EXPECT_EQ(Best(resumed)->theta, Best(whole)->theta) << i;
    EXPECT_EQ(Best(resumed)->shapes, Best(whole)->shapes) << i;
    EXPECT_EQ(Best(resumed)->cost, Best(whole)->cost) << i;
    EXPECT_EQ(resumed.iterations, whole.iterations) << i;
    EXPECT_EQ(resumed.counts.rollouts, whole.counts.rollouts) << i;
  }
}

TEST_F(NestedStateTest, ReportsEachModelAsItsShare) {
  double last = 0.0;
  std::string notes;
  control_.progress = [&](double fraction, const std::string& note) {
    EXPECT_GE(fraction, last - 1e-12) << note;
    EXPECT_LE(fraction, 1.0);
    last = fraction;
    notes += note + "\n";
  };
  Run();
  EXPECT_GT(last, 0.75);
  EXPECT_THAT(notes, testing::HasSubstr("isotropic, 2 numbers, initial guesses"));
  EXPECT_THAT(notes, testing::HasSubstr("linear, 7 numbers, round 1"));
}

TEST_F(NestedStateTest, ACancelInASimplerModelGivesTheBestSoFar) {
  std::atomic<bool> cancel = false;
  control_.cancel = &cancel;
  control_.save = [&](const StagedFitState& state) {
    cancel = state.models_done == 1 && Best(state) != nullptr;
  };
  const StagedFitState part = Run();
  const FitCandidate* best = Best(part);
  ASSERT_NE(best, nullptr);
  ASSERT_EQ(best->theta.size(), kMaterialEntries);
  const MaterialField material = FittedMaterial(fit_.options, *best);
  EXPECT_LT((fit_.backend.Shape(material) - best->shapes[0]).norm(), 1e-12);
}

// The tables of the drape are the second of the start tables.
TEST_F(NestedStateTest, TheBestOfSeveralStartTablesIsKept) {
  fit_.problem.simpler_models = {};
  fit_.options.grid.stretch = fit_.options.grid.bend = {1.0};
  fit_.options.candidates_per_round = {2};
  fit_.options.iterations = {0};
  fit_.problem.other_materials = {Scaled(fit_.problem.material, 3.0, 1.5),
                                  Scaled(fit_.problem.material, 2.0, 1.0)};
  const FitCandidate best = *Best(Run());
  EXPECT_EQ(best.guess.table, 1);
  EXPECT_LT(best.profile_rms, 1e-9);
}

}  // namespace
}  // namespace drape
