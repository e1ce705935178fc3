// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/fit_captures.h"
#include "tools/accuracy_option.h"

namespace drape {

// What a user of drape_fit sets: the job, and what it holds as names.
struct FitToolOptions {
  FitJob job;
  std::vector<std::string> images;    // files, folders, patterns (ExpandImages)
  FitSelection data;                  // captures of the data set in place of images
  std::string targets = "silhouettes";  // ParseTargetSource
  std::vector<std::string> tests;     // the same (ExpandTests)
  std::string parameters = "39";      // ParseTying
  std::string tables = "given";       // ParseTableForm
  std::string integrator = "static";  // ParseIntegrator
  std::string field_basis = "elements";  // ParseFieldBasis
  std::string field_groups = "scales";   // ParseFieldGroups
  AccuracyChoice accuracy;            // fills what the user has not given
  std::string out;                    // folder, made when missing
};

// The job with its names looked up and its files listed; without its output files. Throws
// InputError.
FitJob FitJobOf(const FitToolOptions& options);

// Runs the job. The results appear in `out` together at the end; checkpoint.json and fit.log are
// there while it runs. Throws InputError; then earlier results are as they were.
FitJobResult RunFitTool(const FitToolOptions& options, const FitJobCallbacks& callbacks);

// "seed grid, best 1.23 px".
std::string ProgressNote(const FitProgress& progress);

}  // namespace drape
