// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "solver/studies/optimisers/methods/search/search_method.h"

namespace drape {

// Evolution strategy with adaptation of the covariance matrix, (μ/μ_w, λ) with rank-one and
// rank-μ updates and cumulative step-size control, all constants by the defaults of [Hansen 2016,
// appendix A], without negative weights. The mean begins at 0, which is also the first point, with
// the given step size. A sample outside the box |θ_i| ≤ bound is drawn again up to ten times, then
// clipped. Points that cannot be evaluated rank last; in a generation without any other the step
// size is halved instead.
class CmaEs final : public SearchMethod {
 public:
  CmaEs(int size, double bound, double step_size, uint64_t seed);

  Eigen::VectorXd Propose() override;
  void Report(std::optional<double> cost) override;
  // All standard deviations are below 1e-9, or the covariance matrix is nearly singular.
  bool converged() const override { return converged_; }

  double step_size() const { return step_size_; }

 private:
  Eigen::VectorXd Sample();
  void Update();
  void Decompose();

  int size_;  // P
  double bound_;
  int lambda_;               // samples of a generation
  Eigen::VectorXd weights_;  // [μ], of sum 1
  double mu_eff_, c_sigma_, d_sigma_, c_c_, c_1_, c_mu_, chi_;
  std::mt19937_64 random_;
  Eigen::VectorXd mean_, path_sigma_, path_c_;
  Eigen::MatrixXd covariance_, axes_;  // C = axes·diag(deviations²)·axesᵀ
  Eigen::VectorXd deviations_;
  double step_size_;
  int generation_ = 0;
  bool started_ = false, converged_ = false;
  std::vector<Eigen::VectorXd> samples_;  // of this generation
  std::vector<double> costs_;             // infinity: cannot be evaluated
};

}  // namespace drape
