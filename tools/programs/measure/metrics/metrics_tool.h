// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_metrics sets.
struct MetricsOptions {
  std::vector<std::string> operands;  // files and folders; none with a data set
  CameraInput camera;
  DiscsInput discs;
  std::string centre = "auto";  // CentreMode; auto: outline for drapes by themselves
  DatasetQuery data;            // its folder: none with operands
  std::string csv;              // file of the drapes measured by themselves
  std::string overlay;          // picture of one
  std::string out;              // JSON file
};

// Points into `options`, which outlives it.
OptionTable MetricsTable(MetricsOptions& options);

// Measures one file, a folder or several files, compares two files or folders, or lists a data set
// and evaluates its trivial predictors. Returns the table for a terminal, nothing when cancelled;
// writes the files that the options name. Throws InputError, also when not one of several drapes
// can be measured.
std::string RunMetrics(const MetricsOptions& options, const RunControl& control);

// The program drape_metrics.
int MetricsMain(int argc, char** argv);

}  // namespace drape
