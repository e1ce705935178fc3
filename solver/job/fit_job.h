// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_report.h"
#include "solver/job/fit_spec.h"

namespace drape {

// The protocol of drape_fit [METHODS, P18] on what has been read.

// How a caller stores a fit while it runs; drape_fit keeps a checkpoint.
struct FitStore {
  // Returns the state in which the fit of one table begins. It is called once, after the laboratory
  // measurements were fitted; `ready`: the images can be fitted.
  std::function<StagedFitState(const FitInput&, const StagedFitOptions&, bool ready)> begin = {};
  std::function<void(const StagedFitState&)> save = {};  // called after each unit of work
  std::function<void(const std::string&)> log = {};      // takes one line for each candidate
};
struct StoredFit {
  FitReport report;
  StagedFitState state;  // in which the fit of one table ended
};

// Fits the data of `input`, laboratory measurements too, which are fitted first; their tables
// replace the start tables.
StoredFit FitFromInput(const FitSpec& spec, FitInput& input, const FitStore& store,
                       const RunControl& control);

// The fitted drapes [m], shape [3V] each: of the fields or of the posterior, where there are some.
const std::vector<Eigen::VectorXd>& FittedShapes(const FitReport& report, const FitCandidate& best);
// The cloth of the mesh on which a fit ended.
const FitInput::Cloth& FindFittedCloth(const FitInput& input, const StagedFitState& state);

// Throws where a result cannot be written (CheckReplaceable), before any is.
void CheckTargets(const FitSpec& spec, const FitProblem& problem, const FitFiles& files);

// A fit from files to files: what drape_fit does.

struct FitJobResult {
  bool cancelled = false;  // the files hold the best so far
  bool fitted = false;     // false: nothing could be fitted, see summary.json
  bool has_posterior = false;
  std::string table;  // for a person: one line per image and per lab point, the material, and the
                      // verdict
  std::vector<std::string> results;  // names of the files to look at: pictures, material
};

// Laboratory measurements are first fitted alone from the start tables. With images, the staged fit
// follows: it starts from the tables of that fit, on which its prior is centred, and each candidate
// has the measurements' residuals beside those of the outlines; the initial guesses do not scale
// what has been measured (bend after a cantilever, stretch after a tensile test).
// Reads and checks all input before it computes. Writes to files.out: summary.json, material.json,
// and for each image fit_<name>.png, drape_<name>.obj and start_<name>.json; kHeterogeneous also
// material_homogeneous.json and fields.json, kBayes and kBdp
// material_homogeneous.json, base.json and posterior.json. The notes of progress are those of
// StagedFitControl. Throws InputError.
FitJobResult RunFitJob(const FitSpec& spec, const FitData& data, const FitFiles& files,
                       const RunControl& control);

// Continues from files.checkpoint where the fit can, and otherwise runs from the beginning.
FitJobResult ContinueFitJob(const FitSpec& spec, const FitData& data, FitFiles files,
                            const RunControl& control);

// ContinueFitJob into a folder of the fit's own, which is made. An InputError is a reason why
// nothing was fitted, in `failure`. Throws IoError.
struct FolderFit : FitJobResult {
  std::string failure;
};
FolderFit FitIntoFolder(const FitSpec& spec, const FitData& data, const std::string& folder,
                        const std::function<nlohmann::ordered_json()>& provenance,
                        const RunControl& control);

}  // namespace drape
