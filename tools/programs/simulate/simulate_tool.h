// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/util/run_control.h"
#include "solver/forward/simulation.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// A drape as the camera sees it.
struct DrapeView {
  GrayImage silhouette;                     // coverage by 4×4 samples a pixel
  std::optional<double> drape_coefficient;  // by the area of the coverage; none for a cloth or a
                                            // support of other radii than the discs', and with a
                                            // fault
  std::string fault;                        // why this is no picture of a drape: "tangled" (its
                                            // area is less than the support's or more than the
                                            // cloth's), "not all in the picture", "too small in the
                                            // picture"; or empty
  std::optional<int> folds;                 // none where the outline has gaps
  std::optional<SilhouetteMetrics> metrics;  // against an image, where one is given
};

// What is measured of a cloth that lies on no support: a strip or a plate.
struct StripView {
  double length;       // at rest, from the last held vertex to the far end along x [m]
  double drop, reach;  // of the tip below and beyond the last held vertex [m]
  double chord;        // angle of the tip below the horizontal, seen from there [°]
  double stretch;      // distance of the tip from there by `length`
};
struct UnsupportedView {
  double largest_move;             // of a vertex from rest [m]
  double sag;                      // of the lowest vertex below rest [m]
  std::optional<StripView> strip;  // where the scene holds a half-plane along x
};

// What a user of drape_simulate sets.
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

// Reads and checks all input before it computes. Writes to options.out summary.json and, of the
// last good shape, drape.obj, silhouette.png and the states asked for; a failed or cancelled run
// writes its last good state too. Throws InputError; earlier results are then unchanged.
SimulateResult RunSimulate(const SimulateOptions& options, const RunControl& control);

// Points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);

// The program drape_simulate.
int SimulateMain(int argc, char** argv);

}  // namespace drape
