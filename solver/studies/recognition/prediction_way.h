// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/prediction/generative/distribution_fit.h"

namespace drape {

// The drapes of one sample.
struct DrapesOfSample {
  int fabric = 0;  // from 0
  std::vector<TrainingDrape> drapes = {};
};

// Compares the drapes of each sample with predictions of the fabrics: distributions of specimens
// that are learned from all samples of a fabric, and from all but this one of its own [METHODS,
// P62]. Returns minus the energy score of the drapes under each fabric: the mean over the captures
// of a face, which repeat each other, summed over the faces; shape [samples][fabrics]. These are
// log probabilities up to a constant factor (loss-likelihood [Bissiri 2016]), which AddProduct
// finds, and a constant. Of each fabric two samples or more (CHECK). Of `options`, resamples and
// cross_validate are not used. Empty when cancelled. Throws InputError (prefix "pool") where the
// pool has too few drapes near a fabric.
std::vector<Eigen::VectorXd> CompareByPredictions(const DrapePool& pool,
                                                  const std::vector<DrapesOfSample>& samples,
                                                  int fabrics,
                                                  const DistributionFitOptions& options,
                                                  const RunControl& control);

}  // namespace drape
