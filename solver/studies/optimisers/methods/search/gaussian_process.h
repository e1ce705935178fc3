// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace drape {

// Regression by a Gaussian process with mean zero [Rasmussen 2006, chapters 2, 4 and 5].

// Correlation at the scaled distance ρ, ρ² = Σ (x_i − x'_i)²/ℓ_i²: exp(−ρ²/2), or
// (1 + √5 ρ + 5ρ²/3)·exp(−√5 ρ) [Rasmussen 2006, eq. 4.9 and 4.17].
enum class Kernel { kSquaredExponential, kMatern52 };

// Covariance of observations: s²·correlation, on the diagonal s²·(1 + kNugget) + σ².
inline constexpr double kNugget = 1e-8;

// Logarithms of what shapes the process, [d + 2]: ln s, ln ℓ_1 … ln ℓ_d, ln σ.
using Hyperparameters = Eigen::VectorXd;

// A point is a column, shape [d, n].
class GaussianProcess {
 public:
  GaussianProcess(Kernel kernel, Hyperparameters hyperparameters);

  // Adds an observation at a point by a row of the Cholesky factor, O(n²). False, and nothing is
  // added, where the covariance matrix would not be positive definite in rounding.
  bool Add(const Eigen::VectorXd& point);
  // All at once, O(n³). False as for Add; then there are no points.
  bool SetPoints(const Eigen::MatrixXd& points);
  int size() const { return static_cast<int>(points_.cols()); }  // n
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

  // Of the process without noise at m points, given the values at all points, shape [n].
  struct Posterior {
    Eigen::VectorXd mean, variance;  // [m]
  };
  Posterior Predict(const Eigen::VectorXd& values, const Eigen::MatrixXd& at) const;

  // ln p(values) [Rasmussen 2006, eq. 2.30] and its derivatives by the hyperparameters (eq. 5.9).
  struct Likelihood {
    double log = 0.0;
    Eigen::VectorXd gradient;  // [d + 2]; empty unless requested
  };
  Likelihood ComputeLikelihood(const Eigen::VectorXd& values, bool with_gradient) const;

 private:
  Eigen::MatrixXd Covariance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) const;

  Kernel kernel_;
  Hyperparameters hyperparameters_;
  Eigen::MatrixXd points_;  // [d, n]
  Eigen::MatrixXd factor_;  // lower Cholesky factor [n, n]
};

// The mode of p(values | φ)·p(φ) from `start` by L-BFGS, with a broad normal prior N(start_prior,
// kHyperpriorSd²) on each, which keeps directions without influence finite. At most `iterations`.
inline constexpr double kHyperpriorSd = 3.0;
Hyperparameters FitHyperparameters(Kernel kernel, const Eigen::MatrixXd& points,
                                   const Eigen::VectorXd& values, const Hyperparameters& start,
                                   const Hyperparameters& prior_mean, int iterations);

}  // namespace drape
