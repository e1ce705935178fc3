// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"

namespace drape {

// A posterior as text, numbers and files.

// Mean and standard deviation of the stiffness, estimated by samples: of the fabric under its
// posterior; of model bdp, of single faces and hinges. weights: StiffnessWeights of the fitted
// drapes; EqualStiffnessWeights for the means over the table of [Gong 2024, table 3].
struct PosteriorStiffness {
  double stretch = 0.0, stretch_deviation = 0.0;  // EffectiveStretch [N/m]
  double bend = 0.0, bend_deviation = 0.0;        // EffectiveBend [N m]
};
PosteriorStiffness ComputePosteriorStiffness(const PosteriorFit& fit,
                                             const Eigen::VectorXd& weights);

// For summary.json: each number's prior and posterior beside the Laplace approximation's, evidence,
// k̂, estimated σ.
nlohmann::ordered_json PosteriorJson(const PosteriorFit& fit, const Eigen::VectorXd& weights);

// The content of its files (WritePosterior).
StoredPosterior MakeStoredPosterior(const PosteriorFit& fit);

// For a person: the stiffness, how many log factors the data determine, and whether k̂ allows
// to rely on it.
std::string PosteriorTable(const PosteriorFit& fit, const Eigen::VectorXd& weights);

}  // namespace drape
