// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/fit/lab/strip_report.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/fit/spectrum.h"
#include "solver/job/drape_report.h"
#include "solver/job/fit_job.h"

namespace drape {

// All that is known at the end of a job, before it becomes files.
struct FitReport {
  std::vector<DrapeReport> drapes;        // of the targets
  std::optional<FitSummary> tests_alone;  // where there are mechanical tests
  std::vector<StripReport> tests;         // with the fitted material
  MaterialField material;                 // no tables when nothing could be fitted; of model heter
                           // that of the fields, of bayes and bdp the posterior's median
  std::optional<FieldFit> fields;         // model heter
  std::optional<PosteriorFit> posterior;  // models bayes, bdp
  Spectrum spectrum;                      // empty when the drapes are not stable
  std::vector<std::string> notes;         // what a reader of the figures must know
  double report_seconds = 0.0;
  bool cancelled = false;

  bool fitted() const { return !material.stretch.empty(); }
};

// Writes summary.json, material.json and for each target fit_<name>.png, drape_<name>.obj and
// start_<name>.json, each atomically. Without targets the fit is that of the tests alone. Throws
// InputError when it cannot. Model heter: also what WriteFields writes, and
// material_homogeneous.json; a reason for missing maps becomes a note. Models bayes and bdp: also
// material_homogeneous.json, posterior.json and base.json, the tables that its log factors are on.
void WriteFitReport(const FitJob& job, const FitProblem& problem, const StagedFitState& state,
                    FitReport& report);

// For a person: one line an image, the means, and the material beside `truth` when given.
std::string FitTable(const FitProblem& problem, const FitReport& report,
                     const MaterialField* truth);

}  // namespace drape
