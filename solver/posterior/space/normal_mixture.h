// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

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
// The directions with a ratio below `most`, at most `count` of them.
DeterminedDirections FindDetermined(const Eigen::MatrixXd& covariance, int count,
                                    double most = kDeterminedRatio);

// What the data alone say where the posterior follows from a standard normal prior about `centre`:
// the likelihood as a normal distribution. A variance is at most kMostNoise, of directions that the
// data hardly determine.
inline constexpr double kMostNoise = 100.0;
NormalDistribution WithoutPrior(const NormalDistribution& posterior, const Eigen::VectorXd& centre);

// A mixture of normal distributions.
struct NormalMixture {
  std::vector<double> weights;  // with the sum 1
  std::vector<NormalDistribution> components;

  int size() const { return static_cast<int>(components.size()); }
  // ln Σ_k weight_k·N(x.mean; mean_k, covariance_k + x.covariance) [nat]: the log likelihood of a
  // noisy observation of a sample. Computed by the largest term, so that it is finite for every
  // observation.
  double LogLikelihood(const NormalDistribution& x) const;
  // Mean and covariance of the mixture as a whole.
  NormalDistribution Moments() const;
};

// Extreme deconvolution [Bovy 2011]: the mixture of `components` normal distributions from which
// the true values of noisy observations were drawn, by expectation maximisation from
// several starts. Where observations are few the covariances are shrunk, as by further observations
// of equal scatter in all directions (one for one component) or of the scatter of all (as many as
// there are directions, for each of several components). observations: at least one, of one size.
NormalMixture Deconvolve(const std::vector<NormalDistribution>& observations, int components);

// The number of components, 1 … most, by the log likelihood of each observation under the mixture
// of the others: the least whose mean is within one standard error of the best, that of the paired
// differences [Hastie 2009].
struct ComponentChoice {
  int components = 1;
  // Σ ln p(left out) by the number of components, from 1, and its terms by observation under the
  // chosen number.
  std::vector<double> log_likelihoods, left_out;
};
// At least two observations. Not more components than a third of the observations.
ComponentChoice ChooseComponents(const std::vector<NormalDistribution>& observations, int most);

}  // namespace drape
