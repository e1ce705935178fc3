// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_report.h"

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

}  // namespace drape
