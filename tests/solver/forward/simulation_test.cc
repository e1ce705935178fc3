// SPDX-License-Identifier: Apache-2.0
// A simulation in pieces is one rollout; its Newton ends at a stable equilibrium; it can be
// cancelled.
#include "solver/forward/simulation.h"

#include <gmock/gmock.h>

#include <atomic>

#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

using testing::ElementsAre;

class SimulationTest : public testing::Test {
 protected:
  SimulationTask Task(int steps) const {
    SimulationTask task;
    task.material = &material_;
    task.start = RandomStart(backend_->model(), 1);
    task.steps = steps;
    task.h = 0.1;
    return task;
  }

  std::unique_ptr<Backend> backend_ = SmoothDisc(100);
  MaterialField material_ = TestMaterial();
};

TEST_F(SimulationTest, ItsPiecesAreOneRollout) {
  SimulationTask task = Task(45);
  task.stops = {0, 7, 45};
  std::vector<int> seen;
  task.on_state = [&](int step, const State&) { seen.push_back(step); };
  const SimulationResult result = Simulate(*backend_, task, {});
  EXPECT_EQ(result.outcome, SimulationOutcome::kDone);
  EXPECT_THAT(seen, ElementsAre(0, 7, 45));
  const RolloutInput input{task.material, &task.start};
  const RolloutResult whole =
      backend_->Rollouts({&input, 1}, {.h = task.h, .steps = 45}, nullptr).front();
  EXPECT_EQ(result.end.x, whole.end.x);
  EXPECT_EQ(result.end.v, whole.end.v);
}

TEST_F(SimulationTest, NewtonEndsAtRest) {
  SimulationTask task = Task(60);
  task.newton = true;
  const SimulationResult result = Simulate(*backend_, task, {});
  EXPECT_EQ(result.outcome, SimulationOutcome::kDone) << result.status;
  ASSERT_TRUE(result.newton_iterations.has_value());
  EXPECT_EQ(result.end.v.norm(), 0.0);
  EXPECT_LT(ForceResidual(backend_->model(), material_, result.end.x), 1e-6);
}

TEST_F(SimulationTest, ACancelKeepsTheLastState) {
  std::atomic<bool> cancel = false;
  int states = 0;
  SimulationTask task = Task(60);
  task.newton = true;
  task.on_state = [&](int, const State&) { ++states; };
  const SimulationResult result =
      Simulate(*backend_, task,
               {.cancel = &cancel, .progress = [&](double, const std::string&) { cancel = true; }});
  EXPECT_EQ(result.outcome, SimulationOutcome::kCancelled);
  EXPECT_LT(result.steps, 60);
  EXPECT_EQ(states, 1);
  EXPECT_FALSE(result.newton_iterations.has_value());
  EXPECT_TRUE(result.end.x.allFinite());
}

}  // namespace
}  // namespace drape::test
