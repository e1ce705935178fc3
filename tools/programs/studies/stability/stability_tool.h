// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/runner/study.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_stability sets.
struct StabilityOptions {
  std::string mesh = "disc:120";  // ParseMeshSpec
  std::string material;           // ReadMaterial
  std::string base;               // of a material without stretch (ApplyBase)
  std::string start;              // start shape
  int seed = 1;
  double duration = 6.0;
  int max_steps = 600;
  int max_newton_steps = 200;
  int max_explicit_steps = 60000;
  double max_seconds = 60.0;
  double drag = 8.0;
  std::vector<std::string> maps;  // ParseStabilityMaps
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};
  int threads = 0;  // 0: all cores
  StudyOptions study;
};

// Points into `options`, which outlives it.
OptionTable StabilityTable(StabilityOptions& options);

// The program drape_stability.
int StabilityMain(int argc, char** argv);

}  // namespace drape
