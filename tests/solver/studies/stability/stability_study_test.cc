// SPDX-License-Identifier: Apache-2.0
// The stability atlas: its rules on made-up states, its maps and cells, and boundaries of it that
// are known to stand where they do.
#include "solver/studies/stability/stability_study.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Outcome = StabilityOutcome;
using Method = StabilityMethod;

StabilitySetting FeltSetting() {
  const std::string configs = std::string(DRAPE_SOURCE_DIR) + "/configs/";
  return {.mesh = MakeDisc({.target_vertices = 100}),
          .material = ReadMaterial(configs + "fabrics/synthetic_felt.json").field,
          .start = ReadStartShape(configs + "starts/four_waves.json"),
          .duration = 4.0,
          .max_steps = 600,
          .max_newton_steps = 300,
          .max_explicit_steps = 30000};
}

class AtlasTest : public testing::Test {
 protected:
  Outcome FindOutcome(const StabilityCase& run) {
    return ParseName<Outcome>(runner_.Run(run, never_)->at("outcome"), "outcome");
  }
  double Limit(const StabilityCase& run) { return runner_.MeasureLimit(run).at("measured_s"); }

  std::atomic<bool> never_ = false;
  StabilityRunner runner_{FeltSetting()};
};

// Each of these runs is a cell of configs/studies/stability.json or lies between two.

TEST_F(AtlasTest, ExplicitStandsAtHalfTheLimitAndFallsAboveIt) {
  const nlohmann::json limit = runner_.MeasureLimit({});
  const double theory = limit.at("theory_s"), measured = limit.at("measured_s");
  std::printf("theory %.4g ms, measured %.4g ms\n", 1e3 * theory, 1e3 * measured);
  EXPECT_NEAR(measured / theory, 1.0, 0.08);
  EXPECT_EQ(FindOutcome({.method = Method::kExplicit, .h = 0.5 * theory}), Outcome::kSettled);
  EXPECT_EQ(FindOutcome({.method = Method::kExplicit, .h = 1.3 * theory}), Outcome::kDiverged);
}

TEST_F(AtlasTest, ExplicitLimitFollowsDensityNeedlesAndHandles) {
  const double usual = Limit({});
  EXPECT_NEAR(Limit({.density = 0.05}) / usual, 0.5, 0.03);
  EXPECT_NEAR(Limit({.handle = 100.0}) / usual, 0.121, 0.02);
  const nlohmann::json needles = runner_.MeasureLimit({.sliver = 100.0});
  const double theory = needles.at("theory_s"), measured = needles.at("measured_s");
  EXPECT_LT(measured / usual, 0.2);
  EXPECT_NEAR(measured / theory, 0.85, 0.2);
}

TEST_F(AtlasTest, OneSolveStepSettlesAtAnyStepButTheSmallest) {
  for (const Method method : {Method::kStep, Method::kStepPcg, Method::kStepFloat})
    for (const double h : {0.05, 0.5})
      EXPECT_EQ(FindOutcome({.method = method, .h = h}), Outcome::kSettled)
          << ToString(method) << h;
  EXPECT_EQ(FindOutcome({.method = Method::kStep, .h = 1e-3}), Outcome::kStillMoving);
}

TEST_F(AtlasTest, OneSolveStepRecoversFromCompressionAndSomeTangle) {
  EXPECT_EQ(FindOutcome({.method = Method::kStep, .compression = 0.5}), Outcome::kSettled);
  EXPECT_EQ(FindOutcome({.method = Method::kStep, .tangle = 0.2}), Outcome::kSettled);
  EXPECT_EQ(FindOutcome({.method = Method::kStep, .tangle = 1.0}), Outcome::kFoldedOver);
}

TEST_F(AtlasTest, SinglePrecisionFailsAtNeedles) {
  StabilityCase run{.method = Method::kStepFloat, .h = 0.2, .sliver = 100.0};
  EXPECT_EQ(FindOutcome(run), Outcome::kSettled);
  run.sliver = 3000.0;
  EXPECT_EQ(FindOutcome(run), Outcome::kFactorFailed);
  run.method = Method::kStep;
  EXPECT_EQ(FindOutcome(run), Outcome::kSettled);
}

TEST_F(AtlasTest, ImplicitEulerSettlesWhereItDamps) {
  EXPECT_EQ(FindOutcome({.method = Method::kImplicit, .h = 0.05}), Outcome::kSettled);
  EXPECT_EQ(FindOutcome({.method = Method::kImplicit, .h = 0.5}), Outcome::kSettled);
  EXPECT_EQ(FindOutcome({.method = Method::kImplicit, .h = 1e-3}), Outcome::kStillMoving);
}

TEST_F(AtlasTest, StaticFromACompressedStartNeedsAShift) {
  StabilityCase run{.method = Method::kStaticNoShift, .compression = 0.8, .pre_steps = 0.0};
  EXPECT_EQ(FindOutcome(run), Outcome::kFactorFailed);
  run.method = Method::kStatic;
  EXPECT_EQ(FindOutcome(run), Outcome::kSettled);
  run = {.method = Method::kStaticNoShift, .compression = 0.8, .pre_steps = 50.0};
  EXPECT_EQ(FindOutcome(run), Outcome::kSettled);
}

TEST_F(AtlasTest, ProjectionCrawlsWhereTheShiftConverges) {
  const nlohmann::json shifted = runner_.Run({.method = Method::kStatic}, never_).value();
  const nlohmann::json projected =
      runner_.Run({.method = Method::kStaticProjected}, never_).value();
  EXPECT_EQ(shifted.at("outcome"), "settled");
  EXPECT_GT(projected.at("steps").get<int>(), 3 * shifted.at("steps").get<int>());
  EXPECT_EQ(FindOutcome({.method = Method::kStaticProjected, .stretch = 100.0, .bend = 100.0}),
            Outcome::kSettled);
}

TEST_F(AtlasTest, DampingOfImplicitEulerIsThatOfTheory) {
  struct Damping {
    double omega, theory, measured;
  };
  const auto measure = [&](Method method, double h) -> Damping {
    const nlohmann::json found = runner_.MeasureDamping({.method = method, .h = h}, 0);
    return {found.at("omega_1_s"), found.at("theory"), found.at("measured")};
  };
  for (const double h : {0.01, 0.1, 0.5}) {
    const Damping newton = measure(Method::kImplicit, h);
    EXPECT_NEAR(newton.theory, 1.0 / std::hypot(1.0, h * newton.omega), 1e-12);
    EXPECT_NEAR(newton.measured / newton.theory, 1.0, 0.01) << h;
  }
  // The approximate Jacobian of the one-solve step is not K: large steps hardly damp more.
  const Damping large = measure(Method::kStep, 0.5), larger = measure(Method::kStep, 2.0);
  EXPECT_LT(large.theory, 0.15);
  EXPECT_GT(large.measured, 5 * large.theory);
  EXPECT_LT(larger.theory, 0.3 * large.theory);
  EXPECT_GT(larger.measured, 0.99 * large.measured);
}

TEST_F(AtlasTest, ASoftClothHasOtherBranches) {
  StabilityCase run{.method = Method::kExplicit, .h = 2e-4, .bend = 0.1};
  EXPECT_EQ(FindOutcome(run), Outcome::kOtherBranch);
  run.bend = 10.0;
  EXPECT_EQ(FindOutcome(run), Outcome::kSettled);
}

// The rules, on a cloth lying flat.
class ClassifyTest : public testing::Test {
 protected:
  Outcome FindOutcome(const StabilityEnd& end) const {
    return Classify(*model_, end, reference_, [&](const Eigen::VectorXd&) { return rest_; });
  }
  StabilityEnd Flat() const { return {.x = model_->mesh.rest_x}; }

  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth");
  Eigen::VectorXd reference_ = model_->mesh.rest_x;
  std::optional<Eigen::VectorXd> rest_;
};

TEST_F(ClassifyTest, NamesWhatIsNoDrape) {
  EXPECT_EQ(FindOutcome(Flat()), Outcome::kSettled);
  StabilityEnd end = Flat();
  end.x[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(FindOutcome(end), Outcome::kDiverged);
  end.x[7] = 2.5;
  EXPECT_EQ(FindOutcome(end), Outcome::kDiverged);
  end = Flat();
  end.status = IntegratorStatus::kNotFinite;
  EXPECT_EQ(FindOutcome(end), Outcome::kDiverged);
  end.status = IntegratorStatus::kNotPositiveDefinite;
  EXPECT_EQ(FindOutcome(end), Outcome::kFactorFailed);
  end.status = IntegratorStatus::kNotConverged;
  EXPECT_EQ(FindOutcome(end), Outcome::kNotConverged);
}

TEST_F(ClassifyTest, NamesWhatIsFolded) {
  StabilityEnd end = Flat();
  end.x[3 * model_->mesh.boundary_loops[0][0] + 2] = 0.031;
  EXPECT_EQ(FindOutcome(end), Outcome::kFoldedOver);
  end = Flat();  // a mirror image lies face down
  for (int i = 0; i < model_->mesh.num_vertices(); ++i) end.x[3 * i] *= -1.0;
  EXPECT_EQ(FindOutcome(end), Outcome::kFoldedOver);
}

TEST_F(ClassifyTest, NamesWhatMovesCreepsOrIsElsewhere) {
  StabilityEnd end = Flat();
  end.speed = 3e-3;
  EXPECT_EQ(FindOutcome(end), Outcome::kStillMoving);
  end = Flat();
  for (int i = 0; i < model_->mesh.num_vertices(); ++i) end.x[3 * i + 2] -= 4e-3;
  rest_ = reference_;  // Newton leads back to it
  EXPECT_EQ(FindOutcome(end), Outcome::kStillMoving);
  rest_ = end.x;
  EXPECT_EQ(FindOutcome(end), Outcome::kOtherBranch);
  rest_.reset();
  EXPECT_EQ(FindOutcome(end), Outcome::kOtherBranch);
  reference_.resize(0);
  EXPECT_EQ(FindOutcome(end), Outcome::kSettled);
}

TEST(StabilityMaps, ALineIsAMapForEachMethod) {
  const std::vector<StabilityMap> maps = ParseStabilityMaps(
      "step+implicit time_step=0.01:1:3 tangle=0.2/0/0.1 density=0.1 law=reference", "maps");
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[1].name, "implicit-time_step-tangle-density0.1-reference");
  EXPECT_THAT(maps[0].values[0], testing::ElementsAre(0.01, 0.1, 1.0));
  EXPECT_THAT(maps[0].values[1], testing::ElementsAre(0.0, 0.1, 0.2));
  ASSERT_EQ(maps[1].Cases().size(), 9u);
  const StabilityCase run = maps[1].Cases()[5];
  EXPECT_EQ(run, (StabilityCase{.method = Method::kImplicit,
                                .law = LawKind::kReference,
                                .h = 1.0,
                                .density = 0.1,
                                .tangle = 0.1}));
  const StabilityMap both = ParseStabilityMaps("step time_step=0.1/1 stiffness=2/3", "x")[0];
  EXPECT_EQ(both.At(0, 1).stretch, 3.0);
  EXPECT_EQ(both.At(0, 1).bend, 3.0);
}

TEST(StabilityMaps, MistakesAreNamed) {
  const auto parse = [](const std::string& line) { return ParseStabilityMaps(line, "maps"); };
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/1"), "expected two axes");
  EXPECT_INPUT_ERROR(parse("stepp time_step=0.1/1 bend=1/2"), "expected one of explicit, step,");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/1 bond=1/2"),
                     "expected one of time_step, stiffness,");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/x bend=1/2"), "found 'x', expected a number");
  EXPECT_INPUT_ERROR(parse("step time_step=-1/1 bend=1/2"), "found '-1', expected a number");
  EXPECT_INPUT_ERROR(parse("step time_step=1:0.1:3 bend=1/2"), "0 < from < to");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1:1:1 bend=1/2"), "expected a count");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/0.1 bend=1/2"), "a value twice");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/1 time_step=1/2"), "names 'time_step' twice");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/1 bend=1/2 stretch=1/2"), "third axis");
  EXPECT_INPUT_ERROR(parse("step h bend=1/2"), "expected axis=values");
  EXPECT_INPUT_ERROR(parse("step time_step=0.1/1 bend=1/2 law=soft"),
                     "expected one of reference, smooth");
}

TEST(StabilityCases, HaveNamesOfWhatIsUnusual) {
  EXPECT_EQ(CaseName({}), "step");
  EXPECT_EQ(CaseName({.method = Method::kStaticNoShift,
                      .law = LawKind::kReference,
                      .stretch = 2.0,
                      .bend = 2.0}),
            "static_no_shift law=reference stretch=2 bend=2");
}

TEST_F(AtlasTest, CellsAreRunsLimitsAndDampingEachOnce) {
  std::vector<StabilityMap> maps;
  for (const char* line :
       {"step time_step=0.1/0.2 stretch=1/2", "step stretch=1/3 time_step=0.1/0.2",
        "explicit time_step=1e-3/2e-3 bend=1/2"})
    maps.push_back(ParseStabilityMaps(line, "maps")[0]);
  Study study = MakeStabilityStudy(runner_, maps, {0.1});
  std::vector<std::string> names;
  for (const StudyCell& cell : study.cells) names.push_back(cell.name);
  EXPECT_THAT(
      names,
      testing::ElementsAre(
          "step time_step=0.1", "step time_step=0.2", "step time_step=0.1 stretch=2",
          "step time_step=0.2 stretch=2", "step time_step=0.1 stretch=3",
          "step time_step=0.2 stretch=3", "explicit time_step=0.001", "explicit time_step=0.002",
          "explicit time_step=0.001 bend=2", "explicit time_step=0.002 bend=2", "limit of explicit",
          "limit of explicit bend=2", "damping of step time_step=0.1 mode=1",
          "damping of step time_step=0.1 mode=10", "damping of implicit time_step=0.1 mode=1",
          "damping of implicit time_step=0.1 mode=10"));
  const nlohmann::json result = study.run(0, {.cancel = &never_}).value();
  EXPECT_EQ(result.at("outcome"), "settled");
  EXPECT_LT(result.at("distance_m"), 3e-3);
  EXPECT_NEAR(study.run(12, {.cancel = &never_})->at("measured").get<double>(), 0.79, 0.02);
  const nlohmann::ordered_json json = MapsJson(maps);
  EXPECT_EQ(json[1].at("runs"),
            nlohmann::ordered_json({"step time_step=0.1", "step time_step=0.1 stretch=3",
                                    "step time_step=0.2", "step time_step=0.2 stretch=3"}));
  EXPECT_EQ(json[2].at("limits").size(), 2u);
}

}  // namespace
}  // namespace drape
