// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "solver/prediction/generative/distribution_fit.h"

namespace drape {

// What drapes of one specimen say of its numbers, whatever branches they are on [METHODS, P73]: the
// numbers of those drapes of a pool that are most like them, weighted by their likeness and moved
// along a local linear regression on what a camera sees (approximate Bayesian computation
// [Beaumont 2002]). The prior is uniform in NumberRanges.
struct SpecimenPosterior {
  SpecimenNumbers mean;
  std::vector<SpecimenNumbers> samples;
  double effective = 0.0;  // number of drapes, 1/Σw²
  double nearest = 0.0;    // distance of the drape most like it (DistributionFitOptions)

  // Whether the pool has drapes like the seen ones. Where it has not, a regression would lead
  // anywhere, and the numbers are those of the most similar drapes.
  bool has_like() const { return nearest <= kFarthestLike; }
  // 1 % of the drapes of a pool of 8,192 are as far from all others, and of 240 real ones 3 are.
  static constexpr double kFarthestLike = 6.0;
};
inline constexpr int kPosteriorDrapes = 400;

// seen: of one face; several drapes count as their mean, so that intervals are at least as wide as
// those of one. samples: their number. A function of its arguments. Throws InputError (prefix
// "pool") where the pool has fewer than twice kPosteriorDrapes drapes.
SpecimenPosterior InferSpecimen(const DrapePool& pool, const std::vector<TrainingDrape>& seen,
                                double outline_weight, int samples, uint64_t seed);

}  // namespace drape
