// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"

namespace drape {

// One simulation of a scene: time steps, Newton's method, or both.
struct SimulationTask {
  const MaterialField* material = nullptr;  // outlives the simulation
  State start;
  bool load_path = false;  // Newton's method takes the flat rest shape along a load path
                           // (SolveFromRest) instead of starting from the last state
  int steps = 100;         // 0: none
  double h = 0.05;         // time step [s]
  bool newton = false;     // Newton's method after the steps
  std::vector<int> stops;  // steps whose states go to `on_state`, 0 … steps
  std::function<void(int step, const State& state)> on_state;  // also after a step that failed
};

enum class SimulationOutcome { kDone, kFailed, kCancelled };

struct SimulationResult {
  SimulationOutcome outcome = SimulationOutcome::kDone;
  std::string status = "ok";  // why it failed
  int steps = 0;              // complete
  State end;                  // the last good one
  std::optional<int> newton_iterations;
  std::vector<std::pair<std::string, double>> seconds;  // by phase [s]
};

// Reads the scene from the backend's model, which must hold the cloth if `newton` is set.
SimulationResult Simulate(Backend& backend, const SimulationTask& task, const RunControl& control);

}  // namespace drape
