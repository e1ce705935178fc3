// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/comparison/model_comparison.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/fit_options.h"

namespace drape {

// What a user of drape_compare sets.
struct CompareToolOptions {
  CompareToolOptions() {
    fit.spec.fields.basis = FieldBasis::kModes;  // elements do not carry over
    job.models = {"homogeneous", "heterogeneous", "bdp", "bayes"};
    job.seeds = {1, 2, 3};
  }

  ComparisonJob job;
  CellChoice cells;
  FitToolOptions fit;                                          // of all experiments
  std::string fabrics = "1-5", train_captures, face = "both";  // ParseIndexList, ClothFace
  std::string out;                                             // folder, made when missing
};

// Points into `options`, which outlives it. What is set for each experiment is not among its
// options.
OptionTable CompareTable(CompareToolOptions& options);

// Runs or continues a comparison; comparison.csv, .json, .md and charts appear in `out` once all
// experiments are done. `text` is what they say. Throws InputError; then what lay there is as it
// was.
// A share of the experiments, or their list, leaves the tables and charts as they are.
struct CompareResult {
  ComparisonRun run;
  std::string text;
};
CompareResult RunCompareTool(const CompareToolOptions& options, const RunControl& control);

// The program drape_compare.
int CompareMain(int argc, char** argv);

}  // namespace drape
