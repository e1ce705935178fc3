// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/job/fit_captures.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/accuracy_option.h"

namespace drape {

// What a user of drape_fit sets: the job, and what it holds as names.
struct FitToolOptions {
  FitJob job;
  std::vector<std::string> images;       // files, folders, patterns (ExpandImages)
  FitSelection data;                     // captures of the data set in place of images
  std::string targets = "silhouettes";   // ParseObservationSource
  std::vector<std::string> tests;        // the same (ExpandTests)
  std::string parameters = "39";         // ParseParameterTying
  std::string tables = "given";          // ParseTableForm
  std::string integrator = "static";     // ParseSolveMode
  std::string field_basis = "elements";  // ParseFieldBasis
  std::string field_groups = "scales";   // ParseFieldGroups
  AccuracyChoice accuracy;               // fills what the user has not given
  std::string out;                       // folder, made when missing
};

// The job with its names looked up and its files listed; without its output files. Throws
// InputError.
FitJob MakeFitJob(const FitToolOptions& options);

// Runs the job. The results appear in `out` together at the end; checkpoint.json and fit.log are
// there while it runs. Throws InputError; then earlier results are as they were.
FitJobResult RunFitTool(const FitToolOptions& options, const FitJobCallbacks& callbacks);

// "seed grid, best 1.23 px".
std::string ProgressNote(const FitProgress& progress);

// Sets the options that the user has not given from --accuracy and says in one line what was picked
// and which error to expect; empty without --accuracy. Throws InputError for an accuracy that the
// table does not have.
std::string ApplyAccuracy(FitToolOptions* options);

// Points into `options`, which outlives it.
OptionTable FitTable(FitToolOptions& options);

}  // namespace drape
