// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "physics/cloth/cloth_model.h"
#include "physics/linalg/linear_solver.h"
#include "physics/material/material.h"

namespace drape {

// The workspace of one thread for the steps of one model [MODEL, M30].
class StepSolver {
 public:
  explicit StepSolver(std::shared_ptr<const ClothModel> model);
  // Uses `linear` in place of MakeLinearSolver's.
  StepSolver(std::shared_ptr<const ClothModel> model, std::unique_ptr<LinearSolver> linear);
  // Returns a solver for another thread, which shares the symbolic analysis.
  StepSolver Clone() const { return StepSolver(model_, linear_->Clone()); }

  const ClothModel& model() const { return *model_; }
  LinearSolver& linear() { return *linear_; }

  // Factors A(x); force() is f(x) afterwards. Returns false when A is not positive definite.
  [[nodiscard]] bool Factor(const MaterialField& material, const Eigen::VectorXd& x, double h);
  const Eigen::VectorXd& force() const { return force_; }
  // Assembles ∂g/∂x with w held.
  const BlockMatrix& StepDerivative(const MaterialField& material, const Eigen::VectorXd& x,
                                    const Eigen::VectorXd& w, double h);

 private:
  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<LinearSolver> linear_;
  Eigen::VectorXd force_;
  BlockMatrix matrix_, derivative_;
};

}  // namespace drape
