// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solver/prediction/generative/distribution_fit.h"
#include "solver/prediction/prediction.h"

namespace drape {

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
