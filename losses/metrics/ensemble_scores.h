// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace drape {

// How well an ensemble of samples from a predicted distribution predicts an observation
// [MODEL, M51]. A lower score is better, and its expectation is smallest for the true distribution.
// Both scores are the fair versions [Ferro 2014], so that ensembles of different sizes are
// comparable.

// The continuous ranked probability score, in the unit of the numbers: mean |X_i − y| − Σ_{i<j}
// |X_i − X_j| / (m(m−1)) over m ≥ 2 samples.
double EnsembleCrps(std::vector<double> samples, double observed);

// The energy score, which is the same for vectors with Euclidean distances
// [Gneiting 2007, section 4.3], for each column of `observed`, shape [d, n]. samples: shape [d, m],
// m ≥ 2.
Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);

// The mean and standard deviation of values.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;  // n − 1; 0 for one value
};
Spread SpreadOfValues(const std::vector<double>& values);

// The central interval by the quantiles at ranks p(m+1). Another sample of the same distribution
// lies in it with exactly the probability `nominal`, which is the requested one, or (m−1)/(m+1)
// when the samples are too few to reach it. m ≥ 2, 0 < probability < 1.
struct CentralInterval {
  double low = 0, high = 0;
  double nominal = 0;

  bool Contains(double value) const { return low <= value && value <= high; }
};
CentralInterval ComputeInterval(std::vector<double> samples, double probability);

}  // namespace drape
