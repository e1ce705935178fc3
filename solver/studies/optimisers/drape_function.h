// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <vector>

#include "solver/fit/outline_residuals.h"
#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

// Which drapes a function accepts.
enum class BranchRule {
  kFollow,  // refusals as the options have them
  kAny      // any stable drape counts until RefineFromBest: for methods that search globally
};

// The residuals of a fit as an optimiser's function: outlines by σ of all observations, then θ by σ
// of the log-prior; ½‖r‖² is the cost of Fit. Each drape is sought from the linear prediction of
// the last point with a Jacobian, so the function follows the branch of its starts; where a drape
// is not found, or refused by the options, it cannot be evaluated.
class DrapeFunction final : public ResidualFunction {
 public:
  // Pointers outlive the object.
  DrapeFunction(Backend* backend, const MaterialParametrisation* parametrisation,
                const std::vector<Observation>* observations, std::vector<State> starts,
                const OutlineResidualOptions& options, double prior_sigma,
                BranchRule rule = BranchRule::kFollow);

  int size() const override { return outlines_.num_parameters(); }
  int num_residuals() const override;
  bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                RowMatrix* jacobian) override;
  double cost_units() const override { return cost_units_; }
  // Follows the branch of the drapes of least cost from here on, by BranchRule::kFollow.
  void RefineFromBest() override;

  // The drapes of least cost so far [m], shape [observations] of [3V]; empty before the first.
  const std::vector<Eigen::VectorXd>& best_shapes() const { return best_shapes_; }

 private:
  int num_outline_residuals() const {
    return outlines_.num_observations() * outlines_.num_angles();
  }
  void Keep(double cost);

  Backend* backend_;
  const std::vector<Observation>* observations_;
  OutlineResidualOptions options_;
  OutlineResiduals outlines_;
  double prior_sigma_;
  double cost_units_ = 1.0;
  double best_cost_ = std::numeric_limits<double>::infinity();
  std::vector<Eigen::VectorXd> best_shapes_;
};

}  // namespace drape
