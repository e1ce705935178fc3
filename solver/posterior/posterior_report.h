// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// A posterior as numbers for people and files.

// Mean and standard deviation of the average stiffness [Gong 2024, table 3], by draws: of the
// fabric under its posterior; of model bdp, of single faces and hinges.
struct PosteriorStiffness {
  double stretch = 0.0, stretch_deviation = 0.0;  // mean over rows of c11 and c22 [N/m]
  double bend = 0.0, bend_deviation = 0.0;        // plate rigidity, mean over the table [N m]
};
PosteriorStiffness ComputePosteriorStiffness(const PosteriorFit& fit);

// For summary.json: each number's prior and posterior beside the Laplace approximation's, evidence,
// k̂, learned σ.
nlohmann::ordered_json PosteriorJson(const PosteriorFit& fit);

// What its files hold (WritePosterior).
StoredPosterior Stored(const PosteriorFit& fit);

// For a person: the belief, how many numbers the data narrow, whether k̂ says to trust it.
std::string PosteriorTable(const PosteriorFit& fit);

}  // namespace drape
