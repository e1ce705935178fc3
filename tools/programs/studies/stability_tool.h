// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/material/material_io.h"
#include "solver/studies/stability/stability_study.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_stability sets.
struct StabilityOptions {
  std::string mesh = "disc:120";      // ParseMeshSpec
  std::string fabric = kBuiltInName;  // ReadMaterial; each run sets the density
  std::string start;                  // ReadStartShape
  StabilitySetting setting;           // its mesh, material and start are read from these
  std::vector<std::string> maps;  // ParseStabilityMaps
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};
  StudyOptions study = {.threads = 0};  // 0: all cores
};

// Points into `options`, which outlives it.
OptionTable StabilityTable(StabilityOptions& options);

}  // namespace drape
