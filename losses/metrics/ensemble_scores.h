// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace drape {

// How well an ensemble, draws of a predicted distribution, foretells what was observed. Scores are
// lower for the better and, in expectation, least for the true distribution; both are the fair
// versions [Ferro 2014], so that ensembles of different sizes compare.

// Continuous ranked probability score, in the unit of the numbers:
// mean |X_i − y| − Σ_{i<j} |X_i − X_j| / (m(m−1)). m ≥ 2 draws.
double EnsembleCrps(std::vector<double> draws, double observed);

// The same of vectors, with Euclidean distances [Gneiting 2007, section 4.3], for each
// column of `observed`, shape [d, n]. draws: [d, m], m ≥ 2.
Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& draws, const Eigen::MatrixXd& observed);

// Mean and standard deviation of values.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;  // n − 1; 0 for one value
};
Spread SpreadOfValues(const std::vector<double>& values);

// Central interval by the quantiles at ranks p(m+1), between which a further draw of the same
// distribution lies with exactly the probability `nominal`: the one asked for, or (m−1)/(m+1) when
// the draws are too few to reach it. m ≥ 2, 0 < probability < 1.
struct CentralInterval {
  double low = 0, high = 0;
  double nominal = 0;

  bool Holds(double value) const { return low <= value && value <= high; }
};
CentralInterval ComputeInterval(std::vector<double> draws, double probability);

}  // namespace drape
