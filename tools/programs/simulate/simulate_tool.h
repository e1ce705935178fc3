// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/simulate/simulate_result.h"

namespace drape {

// What a user of drape_simulate sets.
struct SimulateOptions {
  SceneInput scene;
  std::string solve = "dynamic";  // "hybrid": steps, then Newton; "static": Newton alone
  double h = 0.05;                // time step [s]
  int steps = 100;
  CameraInput camera;
  std::string image;             // silhouette to be compared with; empty: none
  std::vector<int> dump_steps;   // steps whose states are written, 0 … steps
  std::string gradient_weights;  // {"w": [3V]}; empty: no gradient
  std::string backend = "auto";  // MakeBackend
  AccuracyChoice accuracy;       // sets the options that the user has not given
  std::string out;               // folder, made when missing
};

// Reads and checks all input before it computes. Writes to options.out summary.json and, of the
// last good shape, drape.obj, silhouette.png and the states asked for; a failed or cancelled run
// writes its last good state too. Throws InputError; earlier results are then unchanged.
SimulateResult RunSimulate(const SimulateOptions& options, const RunControl& control);

// Sets the options that the user has not given from --accuracy and says in one line what was picked
// and which error to expect; empty without --accuracy. Throws InputError for an accuracy that the
// table does not have, or for another scene than the drape test.
std::string ApplyAccuracy(SimulateOptions* options);

// Points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);

}  // namespace drape
