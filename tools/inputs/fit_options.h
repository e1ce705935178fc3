// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/job/fit_input.h"
#include "solver/job/fit_spec.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"

namespace drape {

// The options of drape_fit.
struct FitToolOptions {
  FitSpec spec = FitSpecWithThreads(0);  // 0: all cores
  FitData data;                          // its lists of files follow from the next three
  std::vector<std::string> images;       // files, folders, patterns (ExpandImages)
  std::vector<std::string> lab_tests;    // the same (ExpandLabMeasurements)
  FitSelection selection;                // captures of the data set in place of images
  AccuracyChoice accuracy;               // fills what the user has not given
  std::string out;                       // folder, made when missing
  bool resume = false;
  bool each = false;  // a fit for each image
};

// Options that are of no use beside an experiment, whose file says what is simulated.
inline constexpr const char* kClothOptions[] = {"mesh",    "search_mesh", "coarse_mesh",
                                                "contact", "specimen",    "support"};

// Throws InputError unless each round has its iterations.
void CheckRounds(const StagedFitOptions& stages);

// The spec, checked, with its count of threads. Throws InputError.
FitSpec MakeFitSpec(const FitToolOptions& options);

// Points into `options`, which outlives it.
OptionTable FitTable(FitToolOptions& options);

}  // namespace drape
