// SPDX-License-Identifier: Apache-2.0
// Boundaries of the contact pages of the stability atlas. Each of these runs is a cell of
// configs/studies/stability_contact.json or lies between two.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "physics/simulation/textbook.h"
#include "solver/studies/stability/cases/stability_map.h"
#include "solver/studies/stability/contact/contact_run.h"
#include "solver/studies/stability/contact/contact_theory.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Outcome = StabilityOutcome;
using Method = StabilityMethod;
using Scenario = StabilityScenario;

ContactRun RunCase(const StabilityCase& run) {
  const std::atomic<bool> never = false;
  return RunContact(run, LinearMaterial(160.0, 2e-5, run.density), {}, never).value();
}
Outcome FindOutcome(const StabilityCase& run) { return RunCase(run).outcome; }

TEST(ContactAtlas, APenaltyTunnelsWhereABarrierHolds) {
  StabilityCase run{.h = 3e-3, .scenario = Scenario::kPlate, .speed = 0.1};
  run.method = Method::kPenalty;
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
  run.speed = 3.0;  // 9 mm in a step, the plate has 2
  EXPECT_EQ(FindOutcome(run), Outcome::kPassedThrough);
  for (const Method method : {Method::kImplicit, Method::kStep})
    for (const double speed : {0.1, 3.0, 100.0}) {
      run.method = method;
      run.speed = speed;
      EXPECT_EQ(FindOutcome(run), Outcome::kHolds) << ToString(method) << speed;
    }
}

TEST(ContactAtlas, SheetsPassThroughOneAnotherWithoutSelfContact) {
  StabilityCase run{.h = 0.01, .scenario = Scenario::kSheets, .edge = 0.02};
  run.method = Method::kStep;
  EXPECT_EQ(FindOutcome(run), Outcome::kPassedThrough);
  run.method = Method::kImplicit;
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
}

TEST(ContactAtlas, EdgesCutARodThatIsThinnerThanTheyAllow) {
  StabilityCase run{
      .method = Method::kStep, .h = 0.01, .scenario = Scenario::kRod, .edge = 0.01, .radius = 0.05};
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
  run.radius = 0.01;
  const ContactRun cut = RunCase(run);
  EXPECT_EQ(cut.outcome, Outcome::kCutsIn);
  const double sagitta = run.edge * run.edge / (8.0 * run.radius);
  EXPECT_LT(*cut.distance, 1.3 * sagitta);
  EXPECT_GT(*cut.distance, 0.3 * sagitta);
  run.thickness = 5e-3;  // the remedy
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
}

TEST(ContactAtlas, ASlopeTellsFrictionFromNone) {
  StabilityCase run{
      .method = Method::kImplicit, .h = 0.01, .scenario = Scenario::kSlope, .friction = 0.51};
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
  run.friction = 0.49;
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
  run.method = Method::kStep;  // has no friction
  EXPECT_EQ(FindOutcome(run), Outcome::kOffTheLaw);
  run.friction = 0.0;
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
}

TEST(ContactAtlas, ClothWithoutRoomIsPinched) {
  StabilityCase run{.method = Method::kImplicit, .h = 0.01, .scenario = Scenario::kPinch};
  run.distance = 5e-4;
  EXPECT_EQ(FindOutcome(run), Outcome::kHolds);
  run.distance = 3e-4;  // less than the thickness
  EXPECT_EQ(FindOutcome(run), Outcome::kPinched);
}

TEST(ContactAtlas, TheLawOfFrictionIsThatOfTheModel) {
  StabilityCase run{.scenario = Scenario::kSlope, .friction = 0.6};
  EXPECT_NEAR(SpeedByLaw(run, 1.0, 0.0) / run.creep_speed, 0.592, 1e-3);
  run.friction = 0.0;
  EXPECT_NEAR(SpeedByLaw(run, 1.0, 0.0), 9.8 / std::sqrt(5.0), 1e-9);
  run = {.scenario = Scenario::kSkid, .speed = 2.0, .friction = 0.3};
  EXPECT_NEAR(SpeedByLaw(run, 0.1, 2.5), 1.25, 1e-12);
  EXPECT_EQ(SpeedByLaw(run, 0.1, 10.0), 0.0);
}

TEST(ContactAtlas, LinesOfTheory) {
  const auto line = [](const std::string& map) {
    return MakeContactLine(ParseStabilityMaps(map, "maps")[0]);
  };
  const StabilityLine jump = line("penalty speed=0.1/1/10 time_step=1e-3/0.01 scenario=plate");
  EXPECT_EQ(jump.x, (std::vector<double>{2.0, 0.2}));
  EXPECT_EQ(jump.y, (std::vector<double>{1e-3, 0.01}));
  const StabilityLine sagitta = line("step edge=0.01/0.02 radius=0.01/0.1 scenario=rod");
  ASSERT_EQ(sagitta.y.size(), 1u);
  EXPECT_NEAR(sagitta.y[0], 0.0625, 1e-12);
  EXPECT_TRUE(line("implicit speed=1/2 time_step=0.1/1 scenario=plate").x.empty());
}

TEST(ContactAtlas, AMethodThatAScenarioDoesNotHaveIsRefused) {
  const auto parse = [](const std::string& map) { ParseStabilityMaps(map, "maps"); };
  EXPECT_INPUT_ERROR(parse("penalty speed=1/2 time_step=0.1/1"), "penalty is a method of");
  EXPECT_INPUT_ERROR(parse("static speed=1/2 time_step=0.1/1 scenario=plate"),
                     "expected one of implicit, penalty, step");
  EXPECT_INPUT_ERROR(parse("step speed=1/2 time_step=0.1/1 scenario=floor"),
                     "expected one of drape, support, ball");
}

}  // namespace
}  // namespace drape
