// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/fit/effective_stiffness.h"
#include "solver/fit/fit.h"
#include "solver/fit/protocol/nested_fit.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/fit/strip_residuals.h"
#include "solver/job/drape_report.h"
#include "solver/job/fit_spec.h"
#include "solver/job/fit_verdict.h"

namespace drape {

// All results of a fit, before they are written.
struct FitReport {
  std::vector<DrapeReport> drapes;    // of the observations
  std::optional<FitSummary> lab_fit;  // of the laboratory measurements alone, where there are some
  std::vector<StripReport> strips;    // with the fitted material
  // No tables when nothing could be fitted; of kHeterogeneous those of the fields, of kBayes and
  // kBdp the posterior's median.
  MaterialField material;
  std::optional<FieldFit> fields;         // kHeterogeneous
  std::optional<PosteriorFit> posterior;  // kBayes, kBdp
  Spectrum spectrum;                      // empty when the drapes are not stable
  Eigen::VectorXd stiffness_weights = EqualStiffnessWeights();  // of the fitted drapes
  std::optional<StiffnessEstimates> stiffness;  // of `material`, means over the cloth
  std::optional<LaboratorySheet> fabric_sheet;  // of `material`
  std::optional<MeshError> mesh_error;          // of its one table; none for a fit on one mesh
  bool density_is_given = false;                // else it is that of the start tables
  const MaterialField* ground_truth = nullptr;  // that the images were made with, if known
  FitVerdict verdict;
  std::vector<std::string> notes;  // what a reader of the figures must know
  double report_seconds = 0.0;
  bool cancelled = false;

  bool fitted() const { return !material.stretch.empty(); }
};

// `problem`: of the whole fit, whose last part `state` is at.
// Writes summary.json, material.json and for each observation fit_<name>.png, drape_<name>.obj and
// start_<name>.json, each atomically. Without observations the fit is that of the laboratory
// measurements alone. kHeterogeneous: also maps of the fields and material_homogeneous.json;
// a reason for missing maps becomes a note. kBayes and kBdp: also material_homogeneous.json,
// posterior.json and base.json, the tables that its log factors are on. Throws InputError when a
// file cannot be written.
void WriteFitReport(const FitSpec& spec, const FitData& data, const FitFiles& files,
                    const FitProblem& problem, const StagedFitState& state, FitReport& report);

// The names of all files that it may write.
std::vector<std::string> ListResultFiles(const FitSpec& spec, const FitProblem& problem);

// The names of the files that a person looks at first: pictures of the outlines, and the material.
std::vector<std::string> MainFiles(const FitProblem& problem, const FitReport& report);

// For a person: one line per image, the means, the material beside `ground_truth` when given, and
// the verdict.
std::string FitText(const FitProblem& problem, const FitReport& report);

}  // namespace drape
