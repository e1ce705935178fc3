// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/stability/stability_survey.h"
#include "solver/studies/stability/stability_theory.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_stability sets.
struct StabilityOptions {
  std::string mesh = "disc:120";  // ParseMeshSpec
  std::string material;           // ReadMaterial
  std::string start;              // start shape
  int seed = 1;
  double duration = 6.0;
  int most_steps = 600;
  int most_newton_steps = 200;
  int most_explicit_steps = 60000;
  double most_seconds = 60.0;
  double drag = 8.0;
  std::vector<std::string> maps;  // ParseStabilityMaps
  std::string only;               // maps with this in their name; empty: all
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};
  int threads = 0;  // 0: all cores
  bool resume = false;
  std::string out;  // folder, made when missing
};

// Points into `options`, which outlives it.
OptionTable StabilityTable(StabilityOptions& options);

// What was found, for the reports.
struct StabilityAtlas {
  struct Limit {
    int map = 0;         // of `maps`
    double value = 0.0;  // on its other axis
    ExplicitLimit limit;
  };
  struct Damping {
    StabilityCase run;
    int mode = 0;
    StepDamping damping;
  };

  bool cancelled = false;
  std::vector<StabilityMap> maps;
  StabilityRuns runs;
  std::vector<Limit> limits;  // of the explicit maps over h
  std::vector<Damping> damping;
  double seconds = 0.0;

  // Of the cases of a map in their order, kNoRun where one is missing.
  std::vector<int> ClassifyRuns(const StabilityMap& map) const;
  StabilityLine MakeLine(int map) const;
};

// Reads all input before it computes. Writes to options.out runs.csv, to which each finished run is
// appended, and at the end findings.json and a PNG a map. A cancelled run draws what it has. Throws
// InputError; then what lay in the folder is as it was.
StabilityAtlas MakeStabilityAtlas(const StabilityOptions& options, const RunControl& control);

}  // namespace drape
