// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/step_solver.h"

#include <utility>

#include "physics/cloth/assembly/assembly.h"

namespace drape {

StepSolver::StepSolver(std::shared_ptr<const ClothModel> model)
    : StepSolver(model, MakeLinearSolver(model->pattern)) {}

StepSolver::StepSolver(std::shared_ptr<const ClothModel> model,
                       std::unique_ptr<LinearSolver> linear)
    : model_(std::move(model)),
      linear_(std::move(linear)),
      matrix_(model_->pattern),
      derivative_(model_->pattern) {}

bool StepSolver::Factor(const MaterialField& material, const Eigen::VectorXd& x, double h) {
  AssembleStep(*model_, material, x, h, force_, matrix_);
  return linear_->Factor(matrix_);
}

const BlockMatrix& StepSolver::StepDerivative(const MaterialField& material,
                                              const Eigen::VectorXd& x, const Eigen::VectorXd& w,
                                              double h) {
  AssembleStepDerivative(*model_, material, x, w, h, derivative_);
  return derivative_;
}

}  // namespace drape
