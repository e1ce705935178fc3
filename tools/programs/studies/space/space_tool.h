// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/posterior/space/material_space.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/studies/runner/study.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/fit_options.h"

namespace drape {

// What a user of drape_space sets.
struct SpaceToolOptions {
  SpaceToolOptions() {
    fit.spec.model = FitModel::kBayes;
    fit.spec.simpler_models = false;  // their tables would be bases of their own
    fit.spec.backend = "cpu";         // fits of one image each run side by side on its threads
    learning.pool.mesh = "disc:600";
  }

  std::vector<std::string> posteriors;  // folders of fits
  std::vector<std::string> added;       // folders of fits, or material files
  SpaceBy by = SpaceBy::kDrape;

  // Fits of a data set instead of posteriors.
  std::string data, fabrics, samples, captures;  // ParseIndexList; empty: all
  FitToolOptions fit;
  bool recognise = false;  // RecognitionJob
  std::vector<std::string> ways = {"posterior", "predictions", "features"};
  LearningOptions learning;  // its further rounds are not used
  StudyOptions study;        // of the fits
};

// Points into `options`, which outlives it.
OptionTable SpaceTable(SpaceToolOptions& options);

int SpaceMain(int argc, char** argv);

}  // namespace drape
