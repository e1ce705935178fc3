// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "solver/posterior/posterior_io.h"

namespace drape {

// Independent samples of what a fit knows of a fabric, or assumed of it.
struct FabricSamples {
  std::vector<std::string> names;     // of the log factors (StoredPosterior::NameFor), [P]
  Eigen::MatrixXd log_factors;        // shape [P, S]
  std::vector<MaterialField> tables;  // of the fabric, without its specimens' factors, [S]
};

// count ≥ 1 samples, which depend on the seed alone. CHECKs kind hierarchy: the deviations of kind
// bdp are a scatter over the cloth, not an uncertainty.
FabricSamples SamplePosterior(const StoredPosterior& posterior, int count, uint64_t seed);
FabricSamples SamplePrior(const StoredPosterior& posterior, int count, uint64_t seed);
// The fabric at log factors of the posterior, shape [P, S].
FabricSamples SamplesAt(const StoredPosterior& posterior, Eigen::MatrixXd log_factors);

// The tables of the fabric at the mean of the log factors, which is the median of every entry.
MaterialField MedianTables(const StoredPosterior& posterior);

}  // namespace drape
