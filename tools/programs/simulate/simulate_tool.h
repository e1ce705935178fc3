// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// The options of drape_simulate.
struct SimulateOptions {
  SceneInput scene;
  std::string solve = "dynamic";  // "hybrid": steps, then Newton; "static": Newton alone
  double h = 0.05;                // time step [s]
  int steps = 100;
  CameraInput camera;
  std::string image;                  // silhouette to be compared with; empty: none
  std::vector<int> dump_steps;        // steps whose states are written, 0 … steps
  std::string backend = "auto";       // MakeBackend
  AccuracyChoice accuracy;            // sets the options that the user has not given
  std::vector<std::string> geometry;  // "vtu"
  std::string out;                    // folder, made when missing
};

// Points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);

}  // namespace drape
