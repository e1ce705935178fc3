// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/forward/random_drapes.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// What a user of drape_equilibria sets.
struct EquilibriaOptions {
  SceneInput scene;                        // its start is not used
  SamplingOptions sampling{.threads = 0};  // 0: all cores
  std::string distance = "vertices";       // ParseBranchMetric
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

// Points into `options`, which outlives it.
OptionTable EquilibriaTable(EquilibriaOptions& options);

// Reads all input before it computes. Writes to options.out summary.json, outlines.json and, of
// each cluster, branch_<i>.json, its drape of least energy as a state to start from (i from 1). A
// cancelled run writes what it has. Throws InputError; then what lay in the folder is as it was.
EquilibriumSurvey SurveyEquilibria(const EquilibriaOptions& options, const RunControl& control);

// One row for each of the largest clusters, then the spread over the drapes and the starts that did
// not come to rest.
std::string EquilibriaTableText(const EquilibriumSurvey& survey);

// The program drape_equilibria.
int EquilibriaMain(int argc, char** argv);

}  // namespace drape
