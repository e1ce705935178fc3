// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/drape_function.h"

namespace drape {

DrapeFunction::DrapeFunction(Backend* backend, const MaterialParametrisation* parametrisation,
                             std::vector<Observation>* targets,
                             const OutlineResidualOptions& options, double prior_sigma)
    : batch_(backend, parametrisation, targets, options), prior_sigma_(prior_sigma) {}

int DrapeFunction::num_residuals() const { return num_outline_residuals() + size(); }

bool DrapeFunction::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                             RowMatrix* jacobian) {
  Eigen::Map<Eigen::VectorXd>(batch_.theta(), size()) = theta;
  const int capped = batch_.counts().capped;
  batch_.PrepareForEvaluation(false, true);
  cost_units_ = batch_.counts().capped > capped ? 0.0 : 1.0;
  // A Jacobian starts from the drape of the trial, which must stand for it.
  if (batch_.all_valid() && jacobian != nullptr) batch_.PrepareForEvaluation(true, false);
  if (!batch_.all_valid()) return false;
  residual->resize(num_residuals());
  for (int i = 0; i < batch_.num_targets(); ++i)
    batch_.Copy(i, residual->data() + i * batch_.num_angles());
  residual->tail(size()) = theta / prior_sigma_;
  Keep(0.5 * residual->squaredNorm());
  if (jacobian == nullptr) return true;
  jacobian->setZero(num_residuals(), size());
  jacobian->topRows(num_outline_residuals()) = batch_.accepted().jacobian;
  jacobian->bottomRows(size()).diagonal().setConstant(1.0 / prior_sigma_);
  return true;
}

void DrapeFunction::Keep(double cost) {
  if (!(cost < best_cost_)) return;
  best_cost_ = cost;
  best_shapes_.resize(batch_.num_targets());
  for (int i = 0; i < batch_.num_targets(); ++i) best_shapes_[i] = batch_.shape(i);
}

}  // namespace drape
