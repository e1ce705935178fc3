// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// Normal distributions of log factors, and how far two of them are apart [METHODS, P60].

struct NormalDistribution {
  Eigen::VectorXd mean;        // shape [P]
  Eigen::MatrixXd covariance;  // positive definite, shape [P, P]

  int size() const { return static_cast<int>(mean.size()); }
};

// ln N(x; mean, covariance) [nat].
double LogDensity(const NormalDistribution& p, const Eigen::VectorXd& x);

// All are of two distributions of one size and invariant under an affine map of the numbers, but
// the last one. Kullback–Leibler divergence of q from p, E_p ln(p/q) [nat].
double KullbackLeibler(const NormalDistribution& p, const NormalDistribution& q);
// −ln ∫√(p·q) [nat].
double Bhattacharyya(const NormalDistribution& p, const NormalDistribution& q);
// √(1 − ∫√(p·q)), a metric, 0 … 1.
double Hellinger(const NormalDistribution& p, const NormalDistribution& q);
// The 2-Wasserstein metric, in the unit of the numbers. Covariances may be singular.
double Wasserstein(const NormalDistribution& p, const NormalDistribution& q);

// The distribution of axes' · x. axes: shape [P, d].
NormalDistribution Project(const NormalDistribution& p, const Eigen::MatrixXd& axes);

// Directions that the data determine: eigenvectors of a posterior covariance in numbers whose prior
// is standard normal, orthonormal, those of least variance first.
struct DeterminedDirections {
  Eigen::MatrixXd axes;    // shape [P, d]
  Eigen::VectorXd ratios;  // variance in the posterior by that in the prior, shape [d], ascending
};
// Half of the prior's standard deviation.
inline constexpr double kDeterminedRatio = 0.25;
// Those with a ratio below `most`, at most `count` of them.
DeterminedDirections FindDetermined(const Eigen::MatrixXd& covariance, int count,
                                    double most = kDeterminedRatio);

// What the data alone say where the posterior follows from a standard normal prior about `centre`:
// the likelihood as a normal distribution. A variance is at most kMostNoise, of directions that the
// data hardly determine.
inline constexpr double kMostNoise = 100.0;
NormalDistribution WithoutPrior(const NormalDistribution& posterior, const Eigen::VectorXd& centre);

}  // namespace drape
