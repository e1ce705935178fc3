// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "solver/forward/simulation.h"
#include "tools/inputs/accuracy_option.h"
#include "tools/inputs/drape_view.h"
#include "tools/inputs/scene_input.h"
#include "tools/inputs/strip_view.h"

namespace drape {

// What a user of drape_simulate sets.
struct SimulateOptions {
  SceneInput scene;
  std::string solve = "dynamic";  // "hybrid": steps, then Newton; "static": Newton alone
  double h = 0.05;                // time step [s]
  int steps = 100;
  CameraInput camera;
  std::string image;                  // silhouette to be compared with; empty: none
  std::vector<int> dump_steps;        // steps whose states are written, 0 … steps
  std::string gradient_weights;       // {"w": [3V]}; empty: no gradient
  std::string backend = "auto";       // MakeBackend
  AccuracyChoice accuracy;            // sets the options that the user has not given
  std::vector<std::string> geometry;  // "vtu"
  std::string out;                    // folder, made when missing
};

// What drape_simulate found, for its summary.
struct SimulateResult {
  SimulationResult simulation;
  std::string backend;                         // Backend::name
  double force_residual = 0.0;                 // ‖f‖ / weight of the last shape
  int self_intersections = 0;                  // of the last shape (CountSelfIntersections)
  Eigen::VectorXd lowest_eigenvalues;          // of K by mass there [s⁻²]; empty: not found
  std::optional<DrapeView> view;               // of the last shape on a support
  std::optional<UnsupportedView> unsupported;  // of the last shape without one
  std::string line;                            // the drape in one line, for a person
};

}  // namespace drape
