// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace drape {

// A peak of a profile r(θ_k), θ_k = 2πk/K, and the lowest place between it and the peak before.
struct Fold {
  int valley = 0, peak = 0;  // k
};

// The peaks with a prominence of at least min_prominence [m] after smoothing by a Gaussian of
// standard deviation 2° (use K ≥ 180: a spacing wider than 2° is not smoothed), counter-clockwise
// from the lowest place of the profile [m], shape [K].
std::vector<Fold> FindFolds(const Eigen::VectorXd& radius, double min_prominence);

}  // namespace drape
