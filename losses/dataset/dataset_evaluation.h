// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/dataset_split.h"
#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"

namespace drape {

// Which drapes of the public data set to use, and how they are split into training and held-out
// samples.
struct DatasetQuery {
  std::string folder;                                    // empty: no data set
  std::string fabric, samples, captures, face = "both";  // ParseIndexList, ClothFace
  int train = 6;            // samples of each fabric; 0: each is left out in turn
  int seed = 1;             // of the split
  std::string split;        // a stored split instead of a random one
  std::string save_split;   // file to store it in
  bool hard_edged = false;  // HardEdged
  bool aligned = true;      // EvaluateTrivialPredictors
};

// A data set: what the loader found, the split, and what it gives without a model.
struct DatasetReport {
  size_t training_images = 0;
  std::vector<Capture> captures;  // selected and usable
  std::vector<FileNote> skipped, notes;
  Split split;  // both sides hold all captures when each sample is held out in turn
  bool in_turn = false;
  std::vector<ObservedCapture> seen_train, seen_held_out;
  TrivialPredictors predictors;
};

// Also stores the split where `query` says so. A cancelled report has neither observed captures nor
// predictors. Throws InputError.
DatasetReport EvaluateDataset(const DatasetQuery& query, const Camera& camera,
                              const RunControl& control);
}  // namespace drape
