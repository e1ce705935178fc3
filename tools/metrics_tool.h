// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "tools/drape_view.h"
#include "tools/option_table.h"

namespace drape {

// What a user of drape_metrics sets.
struct MetricsOptions {
  std::vector<std::string> operands;  // A and B; none with `data`
  CameraInput camera;
  bool hard_edged = false;
  bool aligned = true;
  std::string data;                                      // folder of the data set
  std::string fabric, samples, captures, face = "both";  // of it; ParseIndexList, ClothFace
  int train = 6;                                         // samples a fabric; 0: each left out
  int seed = 1;
  std::string split;       // a stored split in place of a drawn one
  std::string save_split;  // file to store it in
  std::string out;         // JSON file
};

// Points into `options`, which outlives it.
OptionTable MetricsTable(MetricsOptions& options);

// Compares two files, runs or folders, or lists a data set and evaluates its trivial predictors.
// Returns the table for a terminal, nothing when cancelled; writes the JSON file when there is one
// to write. Throws InputError.
std::string RunMetrics(const MetricsOptions& options, const std::atomic<bool>& cancel);

}  // namespace drape
