// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/dataset_input.h"
#include "tools/inputs/drape_view.h"

namespace drape {

// What a user of drape_metrics sets.
struct MetricsOptions {
  std::vector<std::string> operands;  // A and B; none with a data set
  CameraInput camera;
  DatasetQuery data;  // its folder: none with operands
  std::string out;    // JSON file
};

// Points into `options`, which outlives it.
OptionTable MetricsTable(MetricsOptions& options);

// Compares two files, runs or folders, or lists a data set and evaluates its trivial predictors.
// Returns the table for a terminal, nothing when cancelled; writes the JSON file when there is one
// to write. Throws InputError.
std::string RunMetrics(const MetricsOptions& options, const RunControl& control);

}  // namespace drape
