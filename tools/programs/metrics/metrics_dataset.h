// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "losses/dataset/dataset_split.h"
#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "tools/inputs/dataset_input.h"

namespace drape {

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

// Also stores the split where `input` says so. A cancelled one has neither seen captures nor
// predictors. Throws InputError.
DatasetReport EvaluateDataset(const DatasetInput& input, const Camera& camera,
                              const RunControl& control);
std::string DatasetText(const DatasetReport& report);
nlohmann::ordered_json DatasetJson(const DatasetReport& report);

}  // namespace drape
