// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "solver/prediction/generative/distribution_fit.h"
#include "solver/prediction/prediction.h"

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

// Predictions of a fabric by the distribution of its specimens [METHODS, P72]: learned from drapes,
// and sampled for new ones.

struct LearningOptions {
  PoolOptions pool;         // of the first round, where its file is still to be made
  std::string pool_file;    // ReadOrSimulatePool
  int round_drapes = 1024;  // drapes of each further round, near what is inferred before
  int rounds = 3;           // further ones, ≥ 0
  DistributionFitOptions fit;
};

struct LearnedFabric {
  bool cancelled = false;  // then there is nothing else
  DistributionFit fit;
  int at_rest = 0, simulated = 0;  // of the pool, all rounds
};

// Infers the distribution from a pool, simulates a further round of drapes from its resampled
// distributions, widened, and infers it again from all rounds, so often. Throws InputError as
// ReadOrSimulatePool and FitDistribution do.
LearnedFabric LearnFabric(Backend& backend, const std::vector<ObservedCapture>& training,
                          const LearningOptions& options, const RunControl& control);

// Drapes of new specimens, which take the resampled distributions in turn (or the best one, where
// there are none), so that they scatter also as the numbers are uncertain. Of `options` the scales
// of specimens, the bend factors and the start height are not used. Otherwise as SampleDrapes.
std::vector<PredictedDrape> SampleSpecimens(Backend& backend, const DistributionFit& fit,
                                            const PredictionOptions& options,
                                            const std::function<void(int done)>& progress = {});

// The fit as a file for SampleSpecimens and for people. Both throw InputError.
void WriteDistributionFit(const std::string& path, const DistributionFit& fit);
DistributionFit ReadDistributionFit(const std::string& path);

}  // namespace drape
