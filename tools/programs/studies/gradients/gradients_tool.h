// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/gradients/gradient_study.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_gradients sets.
struct GradientsOptions {
  std::string mesh = "disc:300";
  std::string material;
  int start_seed = 3;
  double hem_rms = 5e-3;   // of the start shape [m]
  int direction_seed = 1;  // of the line of materials
  std::vector<int> horizons = {1, 3, 10, 30, 100, 300, 1000};
  std::vector<double> time_steps = {0.02, 0.05, 0.1};  // [s]
  double horizon_step = 1e-6;                          // of the differences there
  int sweep_horizon = 50;  // of the sweep of difference steps, at h = 0.1 s
  int fold_starts = 6;     // branches that are followed to their ends
  std::string out;
};

// Points into `options`, which outlives it.
OptionTable GradientsTable(GradientsOptions& options);

struct GradientSweep {
  std::string name;  // "smooth, 50 steps"
  std::vector<GradientError> errors;
};
struct HorizonSeries {
  std::string law;
  double h = 0.0;
  std::vector<int> horizons;          // those done
  std::vector<GradientError> errors;  // one of each
};
struct FollowedBranch {
  int seed = 0;
  ContinuationResult path;
  std::optional<FoldApproach> approach;
};
struct GradientStudy {
  bool cancelled = false;
  std::vector<GradientSweep> sweeps;
  std::vector<HorizonSeries> horizons;
  std::vector<FollowedBranch> branches;
};

// Writes to options.out summary.json, report.md, differences.png, horizons.png and fold.png; a
// cancelled run what it has. Throws InputError.
GradientStudy StudyGradients(const GradientsOptions& options, const RunControl& control);

// The tables of report.md.
std::string GradientReportText(const GradientStudy& study);

}  // namespace drape
