// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "solver/studies/optimisers/methods/search/embedding.h"
#include "solver/studies/optimisers/methods/search/gaussian_process.h"
#include "solver/studies/optimisers/methods/search/search_method.h"

namespace drape {

// Settings of the code of [Nayebi 2019], which covers BO, REMBO and HeSBO.
struct BayesianSearchOptions {
  Kernel kernel = Kernel::kMatern52;
  enum class Acquisition { kExpectedImprovement, kUpperConfidenceBound };
  Acquisition acquisition = Acquisition::kExpectedImprovement;
  int initial_points = 10;         // 0 and a Latin hypercube
  int candidates = 2000;           // Latin-hypercube points, the best of which is next
  double initial_variance = 1e-3;  // of the noise, in units of the standardised values
};

// Bayesian optimisation of ln(cost) in the box |θ_i| ≤ bound [Jones 1998], through an embedding.
// The values are standardised before each use. A point that cannot be evaluated has the largest
// value so far. Hyperparameters are fitted at every fifth point up to the 25th, then at every 20th.
class BayesianSearch final : public SearchMethod {
 public:
  BayesianSearch(Embedding embedding, double bound, const BayesianSearchOptions& options,
                 uint64_t seed);

  Eigen::VectorXd Propose() override;
  void Report(std::optional<double> cost) override;

  const Embedding& embedding() const { return embedding_; }

 private:
  Eigen::VectorXd Choose();
  bool MustFit() const;
  void Fit(const Eigen::VectorXd& values);
  Eigen::MatrixXd Points() const;
  Eigen::VectorXd StandardisedValues() const;

  Embedding embedding_;
  double bound_;
  BayesianSearchOptions options_;
  std::mt19937_64 random_;
  Eigen::MatrixXd design_;               // the initial points in the box ±1, shape [d, count]
  std::vector<Eigen::VectorXd> points_;  // in the box ±1; the last may be without a value
  std::vector<double> values_;           // ln(cost); of points that failed NaN
  Hyperparameters prior_mean_;
  GaussianProcess process_;
};

}  // namespace drape
