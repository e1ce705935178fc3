// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/step_solver.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/scene_self_contact.h"

namespace drape {
namespace {

bool HasBlocks(const BlockPattern& pattern, const std::vector<SurfaceTouch>& touches) {
  return std::all_of(touches.begin(), touches.end(), [&](const SurfaceTouch& touch) {
    const std::array<int, 4>& vertex = touch.pair.vertex;
    return std::all_of(vertex.begin(), vertex.end(), [&](int i) {
      return std::all_of(vertex.begin(), vertex.end(),
                         [&](int j) { return pattern.Find(i, j) >= 0; });
    });
  });
}

}  // namespace

StepSolver::StepSolver(std::shared_ptr<const ClothModel> model)
    : StepSolver(model, MakeLinearSolver(model->pattern)) {}

StepSolver::StepSolver(std::shared_ptr<const ClothModel> model,
                       std::unique_ptr<LinearSolver> linear)
    : model_(std::move(model)),
      linear_(std::move(linear)),
      matrix_(model_->pattern),
      derivative_(model_->pattern) {
  if (HasSelfContact(model_->scene))
    self_ = std::make_unique<SurfaceContact>(MakeSelfContact(*model_));
}

StepSolver StepSolver::Clone() const {
  StepSolver clone(model_, linear_->Clone());
  clone.SetThreads(threads_);
  return clone;
}

void StepSolver::SetThreads(int threads) {
  threads_ = threads;
  linear_->SetThreads(threads);
  if (wide_) wide_->linear->SetThreads(threads);
}

LinearSolver& StepSolver::linear() {
  if (!wide_) return *linear_;
  wide_->linear->CancelLike(*linear_);
  return *wide_->linear;
}

void StepSolver::Forget() {
  if (!wide_) return;
  wide_.reset();
  MakeMatrices();
}

void StepSolver::MakeMatrices() {
  matrix_ = BlockMatrix(wide_model().pattern);
  derivative_ = BlockMatrix(wide_model().pattern);
}

void StepSolver::Widen(const Eigen::VectorXd& x) {
  if (!self_ || !x.allFinite()) return;
  self_->Know(x);
  if (HasBlocks(wide_model().pattern, self_->ListTouches(x))) return;
  auto model = std::make_shared<ClothModel>(*model_);
  model->pattern =
      MakeBlockPattern(model->mesh, model->scene.stretch, model->scene.bend, self_->ListNear(x));
  std::unique_ptr<LinearSolver> linear = MakeLinearSolver(model->pattern, threads_);
  wide_ = std::make_unique<Wide>(Wide{std::move(model), std::move(linear)});
  MakeMatrices();
}

bool StepSolver::Factor(const MaterialField& material, const Eigen::VectorXd& x, double h) {
  Widen(x);
  AssembleStep(wide_model(), material, x, h, force_, matrix_, self_.get());
  return linear().Factor(matrix_);
}

const BlockMatrix& StepSolver::StepDerivative(const MaterialField& material,
                                              const Eigen::VectorXd& x, const Eigen::VectorXd& w,
                                              double h) {
  Widen(x);
  AssembleStepDerivative(wide_model(), material, x, w, h, derivative_, self_.get());
  return derivative_;
}

}  // namespace drape
