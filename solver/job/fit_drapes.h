// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/job/fit_input.h"
#include "solver/job/fit_report.h"

namespace drape {

// Fits in memory: the whole protocol of drape_fit [METHODS, P18] without files.

// Fits one fabric to what cameras have seen of its drapes. `spec` says how: the model, the meshes,
// the backend; its defaults are the defaults of drape_fit. `start`: the tables from which the fit
// starts, with the fabric's density [kg/m²]. `observations`: at least one, of one size
// (ReadImageObservation reads an image). The report has the fitted tables, the stiffness with its
// uncertainty, the fitted drapes, the posterior of the models bayes and bdp, and the verdict;
// report.fitted() is false where no drape could be fitted. A cancelled fit returns the best so far.
// Throws InputError for a mesh, a table or an option that contradicts the observations, such as
// outlines of other than spec.observation.angles angles.
FitReport FitDrapes(const FitSpec& spec, const MaterialField& start,
                    std::vector<Observation> observations, const RunControl& control = {});

// Samples of the fabric's tables from the posterior of a fit by model bayes, a function of the seed
// alone. Throws InputError for a fit without such a posterior.
std::vector<MaterialField> SamplePosterior(const FitReport& report, int count, uint64_t seed);

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

}  // namespace drape
