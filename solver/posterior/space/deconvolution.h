// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "solver/posterior/space/normal_distance.h"

namespace drape {

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
struct DeconvolutionOptions {
  int starts = 4;
  int iterations = 300;
  double tolerance = 1e-7;  // of the log likelihood per observation
  uint64_t seed = 1;
};
NormalMixture Deconvolve(const std::vector<NormalDistribution>& observations, int components,
                         const DeconvolutionOptions& options = {});

// The number of components, 1 … most, by the log likelihood of each observation under the mixture
// of the others: the least whose mean is within one standard error of the best, that of the paired
// differences [Hastie 2009].
struct ComponentChoice {
  int components = 1;
  // By number of components, from 1: Σ ln p(left out); by observation under the chosen number.
  std::vector<double> log_likelihoods, left_out;
};
// At least two observations. Not more components than a third of the observations.
ComponentChoice ChooseComponents(const std::vector<NormalDistribution>& observations, int most,
                                 const DeconvolutionOptions& options = {});

}  // namespace drape
