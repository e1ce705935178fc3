// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"
#include "tools/inputs/drape_view.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// One drape from files to files: what drape_simulate does.
struct SimulateOptions {
  SceneInput scene;
  std::string integrator = "dynamic";  // "hybrid": steps, then Newton; "static": Newton alone
  double h = 0.05;                     // time step [s]
  int steps = 100;
  CameraInput camera;
  std::string image;             // silhouette to be compared with; empty: none
  std::vector<int> dump_steps;   // states to be written, 0 … steps
  std::string gradient_weights;  // {"w": [3V]}; empty: no gradient
  std::string backend = "auto";  // MakeBackend
  AccuracyChoice accuracy;       // fills what the user has not given
  std::string out;               // folder, made when missing
};

struct SimulateCallbacks {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double fraction, const std::string& note)> progress;
  std::function<void(const std::string& line)> log = {};
};

enum class SimulateOutcome { kDone, kFailed, kCancelled };

struct SimulateResult {
  SimulateOutcome outcome = SimulateOutcome::kDone;
  std::string status = "ok";  // of the physics: why it failed
  std::string line;           // the drape in one line, for a person
};

// Reads and checks all input before it computes. Writes to options.out summary.json and, of the
// last good shape, drape.obj, silhouette.png and the states asked for; a failed or cancelled run
// writes its last good state too. Throws InputError; then what lay in the folder is as it was.
SimulateResult Simulate(const SimulateOptions& options, const SimulateCallbacks& callbacks);

// Sets the options that the user has not given from --accuracy and says in one line what was picked
// and which error to expect; empty without --accuracy. Throws InputError for an accuracy that the
// table does not have, or for another scene than the drape test.
std::string ApplyAccuracy(SimulateOptions* options);

// Points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);

}  // namespace drape
