// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/studies/recognition/sample_list.h"

namespace drape {

// Compares the features of each sample's images, their means over the captures of each face, with
// those of the other samples, without a model of cloth [METHODS, P62]. Returns the log
// probabilities of all fabrics up to a constant, shape [samples][fabrics].
std::vector<Eigen::VectorXd> CompareByFeatures(const SampleList& list);

}  // namespace drape
