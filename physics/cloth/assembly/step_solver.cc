// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/assembly/step_solver.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/scene_self_contact.h"

namespace drape {
namespace {

// Threads wait for one another for longer than they gain with fewer.
constexpr int kVerticesOfPart = 400;

bool HasBlocks(const BlockPattern& pattern, const std::vector<SurfaceTouch>& touches) {
  return std::all_of(touches.begin(), touches.end(), [&](const SurfaceTouch& touch) {
    return pattern.HasAllBlocks(touch.pair.vertex);
  });
}

}  // namespace

StepSolver::StepSolver(const std::shared_ptr<const ClothModel>& model)
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
  const int parts = std::clamp(model_->mesh.num_vertices() / kVerticesOfPart, 1, threads);
  if (parts == 1)
    parts_.clear();
  else if (parts != static_cast<int>(parts_.size()))
    parts_ = SplitAssembly(model_->mesh, parts);
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
  model->pattern = AddGroups(model_->pattern, self_->ListNear(x));
  std::unique_ptr<LinearSolver> linear = linear_->Adapt(model->pattern);
  linear->SetThreads(threads_);
  wide_ = std::make_unique<Wide>(Wide{std::move(model), std::move(linear)});
  MakeMatrices();
}

bool StepSolver::Factor(const MaterialField& material, const Eigen::VectorXd& x, double h) {
  Widen(x);
  AssembleStep(wide_model(), material, x, h, force_, matrix_, self_.get(), parts_);
  return linear().Factor(matrix_);
}

const BlockMatrix& StepSolver::StepDerivative(const MaterialField& material,
                                              const Eigen::VectorXd& x, const Eigen::VectorXd& w,
                                              double h) {
  Widen(x);
  AssembleStepDerivative(wide_model(), material, x, w, h, derivative_, self_.get(), parts_);
  return derivative_;
}

}  // namespace drape
