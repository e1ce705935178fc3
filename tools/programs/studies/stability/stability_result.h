// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/stability/stability_atlas.h"

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
  std::string only;               // maps with this in their name; empty: all
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};
  int threads = 0;  // 0: all cores
  bool resume = false;
  CellChoice cells;
  std::string out;  // folder, made when missing
};

}  // namespace drape
