// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/studies/comparison/comparison.h"
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
  StudyOptions study;
  FitToolOptions fit;                                          // of all runs
  std::string fabrics = "1-5", train_captures, face = "both";  // ParseIndexList, ClothFace
};

// Points into `options`, which outlives it.
OptionTable CompareTable(CompareToolOptions& options);

}  // namespace drape
