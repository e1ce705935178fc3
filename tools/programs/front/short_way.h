// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/cli/option_table.h"

namespace drape {

// drapefit PHOTO --mass=150: from one photograph to a report, by the programs that do each step.
struct ShortWayOptions {
  std::vector<std::string> operands;  // one picture
  double mass = 0.0;                  // of the fabric by area [g/m²]; 0: not given
  double specimen = 0.30;             // diameter [m]
  double support = 0.18;              // diameter [m]
  double focal_35mm = 0.0;       // of the lens, as for a full-frame camera [mm]; 0: from the file
  std::string picture = "auto";  // "photo", "silhouette"
  std::string fit_config;        // of drape_fit; empty: that of two numbers and a posterior
  int draws = 16;                // of the prediction
  int threads = 0;               // 0: all cores
  std::string out;               // empty: out/<name of the picture>
};

// Points into `options`, which outlives it.
OptionTable ShortWayTable(ShortWayOptions& options);

// Runs the steps that are not done yet, with the standard streams of this process, and prints the
// command of each. Stops at the first step that fails and returns its exit code. `folder`: where
// the programs are (ProgramFolder). steps.json in the output folder records the picture and what is
// done: a step is done when it has ended with the same command, build and contents of its inputs.
// Throws InputError for bad options, and for a folder with results of another picture.
int RunShortWay(const ShortWayOptions& options, const std::string& folder);

}  // namespace drape
