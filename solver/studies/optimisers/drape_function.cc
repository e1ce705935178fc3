// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/drape_function.h"

#include <utility>

namespace drape {

namespace {

OutlineResidualOptions Apply(BranchRule rule, OutlineResidualOptions options) {
  if (rule == BranchRule::kAny)
    options.max_outline_change = options.max_jump = std::numeric_limits<double>::infinity();
  return options;
}

}  // namespace

DrapeFunction::DrapeFunction(Backend* backend, const MaterialParametrisation* parametrisation,
                             const std::vector<Observation>* observations,
                             std::vector<State> starts, const OutlineResidualOptions& options,
                             double prior_sigma, BranchRule rule)
    : backend_(backend),
      observations_(observations),
      options_(options),
      outlines_(backend, parametrisation, observations, std::move(starts), Apply(rule, options)),
      prior_sigma_(prior_sigma) {}

void DrapeFunction::RefineFromBest() {
  if (best_shapes_.empty()) return;
  outlines_ = OutlineResiduals(backend_, &outlines_.parametrisation(), observations_,
                               AtRest(best_shapes_), options_);
}

int DrapeFunction::num_residuals() const { return num_outline_residuals() + size(); }

bool DrapeFunction::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                             RowMatrix* jacobian) {
  Eigen::Map<Eigen::VectorXd>(outlines_.theta(), size()) = theta;
  const int capped = outlines_.counts().capped;
  outlines_.PrepareForEvaluation(false, true);
  cost_units_ = outlines_.counts().capped > capped ? 0.0 : 1.0;
  // A Jacobian starts from the drape of the trial, which must be valid for it.
  if (outlines_.all_valid() && jacobian != nullptr) outlines_.PrepareForEvaluation(true, false);
  if (!outlines_.all_valid()) return false;
  residual->resize(num_residuals());
  for (int i = 0; i < outlines_.num_observations(); ++i)
    outlines_.Residuals(i, residual->data() + i * outlines_.num_angles());
  residual->tail(size()) = theta / prior_sigma_;
  Keep(0.5 * residual->squaredNorm());
  if (jacobian == nullptr) return true;
  jacobian->setZero(num_residuals(), size());
  jacobian->topRows(num_outline_residuals()) = outlines_.accepted().jacobian;
  jacobian->bottomRows(size()).diagonal().setConstant(1.0 / prior_sigma_);
  return true;
}

void DrapeFunction::Keep(double cost) {
  if (!(cost < best_cost_)) return;
  best_cost_ = cost;
  best_shapes_.resize(outlines_.num_observations());
  for (int i = 0; i < outlines_.num_observations(); ++i) best_shapes_[i] = outlines_.shape(i);
}

}  // namespace drape
