// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/posterior/space/fabric_belief.h"
#include "solver/studies/recognition/sample_list.h"

namespace drape {

// Of each sample, the log probabilities of all fabrics up to a constant, shape [fabrics].
struct PosteriorLogs {
  std::vector<Eigen::VectorXd> by_posterior;
  std::vector<Eigen::VectorXd> by_density;  // as if weighed with an error of 3 %
};

// Compares each sample by its posterior in the directions that all samples determine, with the
// fabrics as the posteriors of the other samples show them [METHODS, P62]. folder: with the fits of
// the samples. Throws InputError where they determine no direction.
PosteriorLogs CompareByPosterior(const SampleList& list, const std::string& folder, SpaceBy by);

}  // namespace drape
