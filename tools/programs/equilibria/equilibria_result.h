// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/forward/random_drapes.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// What a user of drape_equilibria sets.
struct EquilibriaOptions {
  SceneInput scene;                        // its start is not used
  SamplingOptions sampling{.threads = 0};  // 0: all cores
  std::string distance = "vertices";       // a name of BranchMetric
  double tolerance = 1e-3;                 // of a cluster [m]
  std::string backend = "auto";            // MakeBackend
  std::string out;                         // folder, made when missing
};

// What drape_equilibria found, for its report.
struct EquilibriumSurvey {
  bool cancelled = false;
  std::string backend;  // Backend::name
  std::vector<DrapeSample> samples;
  std::vector<BranchCluster> clusters;
  BranchSpread spread;
  double seconds = 0.0;
};

}  // namespace drape
