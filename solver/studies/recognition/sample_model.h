// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/posterior/space/normal_mixture.h"

namespace drape {

// Samples of fabrics as normal distributions at three levels [METHODS, P62]: fabrics of a
// population, μ_f ~ N(μ, V); samples of a fabric, x_s ~ N(μ_f, W) with one W for all fabrics; what
// is seen of a sample, N(x_s, C_s). With C_s = 0 this is linear discriminant analysis with shrunk
// means.
struct SeenSample {
  int fabric = 0;  // from 0
  NormalDistribution seen;
};

class SampleModel {
 public:
  // Expectation maximisation of μ, V and W [Bishop 2006, chapter 9]; covariances are shrunk as if
  // by one more observation of equal scatter in each direction of `scale`, shape [d].
  SampleModel(const std::vector<SeenSample>& samples, int fabrics, const Eigen::VectorXd& scale);

  // Of a fabric's mean; that of the population where no sample of it was seen.
  const NormalDistribution& fabric(int f) const { return fabrics_[f]; }
  const Eigen::MatrixXd& within() const { return within_; }
  // ln p(seen | fabric), shape [fabrics].
  Eigen::VectorXd LogLikelihoods(const NormalDistribution& seen) const;

 private:
  void FindFabrics(const std::vector<SeenSample>& samples);

  NormalDistribution population_;
  Eigen::MatrixXd within_;
  std::vector<NormalDistribution> fabrics_;
};

// ln p of each sample under the model of all others, shape [samples][fabrics].
std::vector<Eigen::VectorXd> CompareWithOthers(const std::vector<SeenSample>& samples, int fabrics,
                                               const Eigen::VectorXd& scale);

}  // namespace drape
