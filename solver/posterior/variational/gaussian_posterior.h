// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace drape {

// A normal distribution of P numbers u = mean + V·L·ε, ε standard normal. Numbers are in units of
// their prior, which is standard normal itself.
struct GaussianPosterior {
  Eigen::VectorXd mean;      // shape [P]
  Eigen::MatrixXd rotation;  // V, orthogonal, shape [P, P]
  Eigen::MatrixXd factor;    // L, lower triangular with a positive diagonal, shape [P, P]

  int size() const { return static_cast<int>(mean.size()); }
  // Columns of samples from columns of standard normal ones, shape [P, S].
  Eigen::MatrixXd Draws(const Eigen::MatrixXd& standard) const;
  Eigen::MatrixXd Covariance() const;
  Eigen::VectorXd Deviations() const;  // square roots of its diagonal, shape [P]
  // KL(q ‖ N(0, 1)) = ½ Σ mean² + ½ Σ_{i>j} L_ij² + ½ Σ_i (L_ii² − 1 − ln L_ii²).
  double DivergenceFromPrior() const;
};

// The distribution of that mean and covariance, shape [P, P]: V its eigenvectors, those of least
// variance first, which the data determine best, so that L is diagonal.
GaussianPosterior FromCovariance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

// A root R of a covariance, R·Rᵀ = covariance, shape [P, P]; variances that rounding makes negative
// count as zero.
Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& covariance);

// Standard normal samples as columns, shape [size, count], that depend on the seed alone.
Eigen::MatrixXd IndependentSamples(int size, int count, uint64_t seed);

// The same as antithetic pairs (column i + count/2 is minus column i), so that odd moments vanish,
// and with exact second moments in the first min(size, count/2) numbers: Σ ε·εᵀ / count = 1 there.
// count even.
Eigen::MatrixXd BalancedSamples(int size, int count, uint64_t seed);

}  // namespace drape
