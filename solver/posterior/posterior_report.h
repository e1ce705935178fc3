// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/posterior/posterior_io.h"
#include "solver/posterior/posterior_types.h"

namespace drape {

// A posterior as text, numbers and files.

// Mean and standard deviation of the average stiffness [Gong 2024, table 3], estimated by
// samples: of the fabric under its posterior; of model bdp, of single faces and hinges.
struct PosteriorStiffness {
  double stretch = 0.0, stretch_deviation = 0.0;  // mean over rows of c11 and c22 [N/m]
  double bend = 0.0, bend_deviation = 0.0;        // plate rigidity, mean over the table [N m]
};
PosteriorStiffness ComputePosteriorStiffness(const PosteriorFit& fit);

// For summary.json: each number's prior and posterior beside the Laplace approximation's, evidence,
// k̂, estimated σ.
nlohmann::ordered_json PosteriorJson(const PosteriorFit& fit);

// The content of its files (WritePosterior).
StoredPosterior MakeStoredPosterior(const PosteriorFit& fit);

// For a person: the mean stiffness, how many log factors the data determine, and whether k̂ allows
// to rely on it.
std::string PosteriorTable(const PosteriorFit& fit);

}  // namespace drape
