// SPDX-License-Identifier: Apache-2.0
// More numbers never fit worse: a model starts also from the fit by the one that it contains.
#include "solver/fit/protocol/nested_fit.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/statics.h"
#include "solver/fit/effective_stiffness.h"
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
                best->profile_rms, int(state.part_results.size()));
    EXPECT_LE(best->cost, last) << NameFor(model);
    EXPECT_EQ(state.part_results.size(), SimplerModels(model).size());
    for (const PartResult& simpler : state.part_results)
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

// The numbers are those of the finest mesh, whose own drape they are of; the error by the two last
// meshes is what is left of what they change by.
TEST_F(NestedFitTest, AFinerMeshChangesTheNumbersAndTellsTheirError) {
  const std::unique_ptr<Backend> finer = test::SmoothDisc(300);
  const MaterialField reference =
      Scaled(InForm(test::TestMaterial(), TableForm::kIsotropic), 1.0, 8.0);
  const State drape = test::Settled(*finer, reference, test::RandomStart(finer->model(), 1));
  problem_.observations = {test::MakeObservation(finer->model().mesh, drape, 72, "reference")};
  problem_.material = InForm(test::TestMaterial(), TableForm::kIsotropic);
  problem_.search = {fine_.get()};
  problem_.fine = finer.get();
  options_.parameters = ParameterTying::kScales;
  options_.iterations = {5, 10};
  const StagedFitState state = RunNestedFit(problem_, options_, {}, {});
  const FitCandidate* best = Best(state);
  ASSERT_NE(best, nullptr);
  EXPECT_LT(best->profile_rms, 0.5 * state.part_results[0].profile_rms);
  EXPECT_LT(ForceResidual(finer->model(), FittedMaterial(options_, *best), best->shapes[0]), 1e-8);
  const std::optional<MeshError> error = EstimateMeshError(problem_, options_, state);
  ASSERT_TRUE(error.has_value());
  const double bend = EffectiveBend(FittedMaterial(options_, *best),
                                    StiffnessWeights(finer->model(), best->shapes));
  const double growth =
      double(finer->model().mesh.num_vertices()) / fine_->model().mesh.num_vertices();
  EXPECT_NEAR(error->log_bend * (growth - 1), std::log(bend / state.part_results[0].bend), 1e-12);
  EXPECT_NEAR(bend / EffectiveBend(reference, EqualStiffnessWeights()), 1.0, 0.1);
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
  // Each saved state leads to the next one, and the last to the end of the run: so all lead there.
  void ExpectToGoOn(const StagedFitState& whole) {
    for (std::size_t i = 0; i < saved_.size(); ++i) {
      SCOPED_TRACE(i);
      std::atomic<bool> cancel = false;
      std::optional<StagedFitState> next;
      StagedFitControl control;
      control.cancel = &cancel;
      control.save = [&](const StagedFitState& state) {
        if (!next) next = state;
        cancel = true;
      };
      const StagedFitState end = RunNestedFit(fit_.problem, fit_.options, saved_[i], control);
      ASSERT_EQ(next.has_value(), i + 1 < saved_.size());
      ExpectSame(next ? *next : end, next ? saved_[i + 1] : whole);
    }
  }
  static void ExpectSame(const StagedFitState& a, const StagedFitState& b) {
    EXPECT_EQ(a.parts_done, b.parts_done);
    EXPECT_EQ(a.round, b.round);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.counts.rollouts, b.counts.rollouts);
    ASSERT_EQ(a.candidates.size(), b.candidates.size());
    for (std::size_t i = 0; i < a.candidates.size(); ++i) {
      ASSERT_EQ(a.candidates[i].theta.size(), b.candidates[i].theta.size()) << i;
      EXPECT_EQ(a.candidates[i].theta, b.candidates[i].theta) << i;
      EXPECT_EQ(a.candidates[i].shapes, b.candidates[i].shapes) << i;
      EXPECT_EQ(a.candidates[i].cost, b.candidates[i].cost) << i;
      EXPECT_EQ(a.candidates[i].done, b.candidates[i].done) << i;
    }
  }

  test::FakeFit fit_;
  StagedFitControl control_;
  std::vector<StagedFitState> saved_;
};

TEST_F(NestedStateTest, GoesOnFromEachSavedStateToTheSameAnswer) {
  const StagedFitState whole = Run();
  ASSERT_GT(saved_.size(), 12u);
  ExpectToGoOn(whole);
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
    cancel = state.parts_done == 1 && Best(state) != nullptr;
  };
  const StagedFitState part = Run();
  const FitCandidate* best = Best(part);
  ASSERT_NE(best, nullptr);
  ASSERT_EQ(best->theta.size(), kMaterialEntries);
  const MaterialField material = FittedMaterial(fit_.options, *best);
  EXPECT_LT((fit_.backend.Shape(material) - best->shapes[0]).norm(), 1e-12);
}

TEST_F(NestedStateTest, GoesOnOnFinerMeshes) {
  test::FakeBackend finer(200), finest(300);
  fit_.problem.search = {&fit_.backend, &finer};
  fit_.problem.fine = &finest;
  ASSERT_EQ(CountParts(fit_.problem), 6);
  const StagedFitState whole = Run();
  ASSERT_EQ(whole.parts_done, 5);
  const FitCandidate* best = Best(whole);
  ASSERT_NE(best, nullptr);
  EXPECT_EQ(best->shapes[0].size(), finest.model().num_dofs());
  EXPECT_EQ(whole.part_results.size(), 5u);
  ExpectToGoOn(whole);
}

// Where the drapes are lost on a finer mesh, the fit before it is the result, and no mesh error
// known beyond it.
TEST_F(NestedStateTest, EndsOnTheLastMeshThatHasTheDrapes) {
  test::FakeBackend finer(200), finest(300);
  finest.fails = [](double, double) { return true; };
  fit_.problem.search = {&fit_.backend, &finer};
  fit_.problem.fine = &finest;
  std::string log;
  control_.log = [&](const std::string& line) { log += line + "\n"; };
  const StagedFitState state = Run();
  EXPECT_EQ(state.parts_done, 4);
  EXPECT_EQ(PartProblem(fit_.problem, state.parts_done).fine, &finer);
  ASSERT_NE(Best(state), nullptr);
  EXPECT_EQ(Best(state)->shapes[0].size(), finer.model().num_dofs());
  EXPECT_THAT(log, testing::HasSubstr("its drapes are not stable on"));
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
