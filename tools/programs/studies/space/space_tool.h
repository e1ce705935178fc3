// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/posterior/space/fabric_belief.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/studies/cells/share.h"
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
  std::string out;  // folder, made when missing

  // Fits of a data set instead of posteriors.
  std::string data, fabrics, samples, captures;  // ParseIndexList; empty: all
  FitToolOptions fit;
  bool recognise = false;  // RecognitionJob
  std::vector<std::string> ways = {"posterior", "predictions", "features"};
  LearningOptions learning;  // its further rounds are not used
  CellChoice cells;          // of the fits
};

// Points into `options`, which outlives it.
OptionTable SpaceTable(SpaceToolOptions& options);

// Fits what is to be fitted, in options.out/fabrics or options.out/samples, and writes to
// options.out space.json, distances.csv, heat_map.png, map.png and textile_map.png, or, with
// `recognise`, recognition.md. `text` is what they say. Throws InputError; then what lay there is
// as it was, but for fits and a pool that were made meanwhile. A share of the fits, or their list,
// writes none of these files.
struct SpaceResult {
  bool cancelled = false;
  std::string text;
};
SpaceResult RunSpaceTool(const SpaceToolOptions& options, const RunControl& control);

// The program drape_space.
int SpaceMain(int argc, char** argv);

}  // namespace drape
