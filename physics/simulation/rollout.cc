// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/rollout.h"

#include <glog/logging.h>

#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/contact/surface_contact.h"

namespace drape {
namespace {

// Keeps the factors of the last steps: the way back needs them first.
bool KeepsFactor(const RolloutOptions& options, std::size_t factor_bytes, int step) {
  const std::size_t fitting = options.factor_memory / factor_bytes;
  return static_cast<std::size_t>(options.steps - step) <= fitting;
}

// Replaces state.v by v' at state.x; the factor stays in the solver, the positions as they are.
RolloutStatus SolveVelocity(StepSolver& solver, const MaterialField& material,
                            const Eigen::VectorXd& mass, double h, State& state) {
  if (!solver.Factor(material, state.x, h))
    return solver.linear().cancelled() ? RolloutStatus::kCancelled
                                       : RolloutStatus::kNotPositiveDefinite;
  state.v = mass.cwiseProduct(state.v) + h * solver.force();
  solver.linear().Solve(state.v);
  return state.v.allFinite() ? RolloutStatus::kOk : RolloutStatus::kNotFinite;
}

// Shortens the moves h·v of vertices that would enter an obstacle, and of cloth that would pass
// through itself. Returns whether the step has no derivative: it has, or the cloth touches itself.
bool BlockMoves(StepSolver& solver, double h, State& state) {
  const std::optional<Contact>& contact = solver.model().scene.contact;
  if (!contact) return false;
  Eigen::VectorXd moves = h * state.v;
  bool shortened = ShortenMoves(*contact, state.x, moves);
  SurfaceContact* const self = solver.self_contact();
  if (self != nullptr) shortened = LimitStep(*self, state.x, moves) || shortened;
  if (shortened) state.v = moves / h;
  return shortened || (self != nullptr && !self->FindActivePairs(state.x).empty());
}

// The start of a rollout: out of all obstacles.
RolloutResult Begin(StepSolver& solver, const State& start) {
  const ClothModel& model = solver.model();
  RolloutResult result{RolloutStatus::kOk, start, 0};
  if (!model.scene.contact) return result;
  PushOut(*model.scene.contact, result.end.x);
  if (solver.self_contact() == nullptr) return result;
  if (!result.end.x.allFinite())
    result.status = RolloutStatus::kNotFinite;
  else if (FindSelfOverlap(model, result.end.x))
    result.status = RolloutStatus::kOverlaps;
  return result;
}

// Appends step result.steps. The memory of an earlier recording's factors is used again.
void Record(const LinearSolver& linear, const RolloutOptions& options, const RolloutResult& result,
            Recording& recording) {
  recording.x.push_back(result.end.x);
  recording.v.push_back(result.end.v);
  if (KeepsFactor(options, linear.factor_bytes(), result.steps)) {
    linear.SaveFactor(recording.factor[result.steps]);
  } else {
    recording.factor[result.steps] = {};
  }
}

bool Cancelled(const RolloutOptions& options) {
  return options.cancel != nullptr && options.cancel->load(std::memory_order_relaxed);
}

}  // namespace

void RolloutOptions::Check() const {
  CHECK_GT(h, 0.0) << "RolloutOptions::h";
  CHECK_GE(steps, 0) << "RolloutOptions::steps";
}

const char* ToString(RolloutStatus status) {
  switch (status) {
    case RolloutStatus::kOk:
      return "ok";
    case RolloutStatus::kNotPositiveDefinite:
      return "step matrix not positive definite";
    case RolloutStatus::kNotFinite:
      return "positions not finite";
    case RolloutStatus::kCancelled:
      return "cancelled";
    case RolloutStatus::kBlocked:
      return "blocked by an obstacle or by itself, where a step has no derivative";
    case RolloutStatus::kOverlaps:
      return "its start passes through itself";
  }
  return "unknown";
}

RolloutStatus AdvanceOneStep(StepSolver& solver, const MaterialField& material,
                             const Eigen::VectorXd& mass, double h, State& state, bool* blocked) {
  const RolloutStatus status = SolveVelocity(solver, material, mass, h, state);
  if (status != RolloutStatus::kOk) return status;
  const bool is_blocked = BlockMoves(solver, h, state);
  if (blocked != nullptr) *blocked = is_blocked;
  if (!(state.x + h * state.v).allFinite()) return RolloutStatus::kNotFinite;
  state.x += h * state.v;
  return status;
}

RolloutResult Rollout(StepSolver& solver, const MaterialField& material, const State& start,
                      const RolloutOptions& options, Recording* recording) {
  options.Check();
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), options.cancel);
  const Eigen::VectorXd mass = solver.model().LumpedMass(material.density);
  RolloutResult result = Begin(solver, start);
  if (recording != nullptr) {
    recording->x.assign(1, result.end.x);
    recording->v.assign(1, result.end.v);
    recording->factor.resize(options.steps);
  }
  bool blocked = false;
  for (; result.status == RolloutStatus::kOk && result.steps < options.steps; ++result.steps) {
    result.status = Cancelled(options)
                        ? RolloutStatus::kCancelled
                        : AdvanceOneStep(solver, material, mass, options.h, result.end, &blocked);
    if (recording != nullptr && blocked) result.status = RolloutStatus::kBlocked;
    if (result.status != RolloutStatus::kOk) break;
    if (recording != nullptr) Record(solver.linear(), options, result, *recording);
  }
  if (recording != nullptr) recording->factor.resize(result.steps);
  return result;
}

namespace {

// Rollout that carries columns of ∂(end)/∂p along, shape [3V, m] each, from what they are at the
// start. add_material(x, w, dv): dv += ∂g/∂p of the step at x.
template <class AddMaterial>
RolloutResult CarryTangents(StepSolver& solver, const MaterialField& material, const State& start,
                            const RolloutOptions& options, const AddMaterial& add_material,
                            RowMatrix& dx, RowMatrix& dv) {
  options.Check();
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), options.cancel);
  const ClothModel& model = solver.model();
  const Eigen::VectorXd mass = model.LumpedMass(material.density);
  RolloutResult rollout = Begin(solver, start);
  for (; rollout.status == RolloutStatus::kOk && rollout.steps < options.steps; ++rollout.steps) {
    const Eigen::VectorXd& x = rollout.end.x;
    rollout.status = Cancelled(options)
                         ? RolloutStatus::kCancelled
                         : SolveVelocity(solver, material, mass, options.h, rollout.end);
    if (rollout.status == RolloutStatus::kOk && BlockMoves(solver, options.h, rollout.end))
      rollout.status = RolloutStatus::kBlocked;
    if (rollout.status != RolloutStatus::kOk) break;
    const Eigen::VectorXd& w = rollout.end.v;
    dv = mass.asDiagonal() * dv;
    AddMultiply(model.pattern, solver.StepDerivative(material, x, w, options.h), dx, dv);
    add_material(x, w, dv);
    solver.linear().Solve(dv);
    dx += options.h * dv;
    rollout.end.x += options.h * w;
  }
  return rollout;
}

}  // namespace

TangentResult RolloutTangent(StepSolver& solver, const MaterialField& material,
                             const MaterialField& weight, const State& start,
                             const RolloutOptions& options) {
  const ClothModel& model = solver.model();
  // One column more than entries: rows of whole vector registers.
  RowMatrix dx = RowMatrix::Zero(model.num_dofs(), kPaddedEntries), dv = dx;
  const auto add_material = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& w, RowMatrix& to) {
    AddMaterialColumns(model, material, weight, x, w, options.h, to);
  };
  RolloutResult rollout = CarryTangents(solver, material, start, options, add_material, dx, dv);
  return {std::move(rollout), dx.leftCols(kMaterialEntries), dv.leftCols(kMaterialEntries)};
}

JvpResult RolloutJvp(StepSolver& solver, const MaterialField& material, const MaterialField& change,
                     const State& start, const State& start_change, const RolloutOptions& options) {
  const ClothModel& model = solver.model();
  CHECK_EQ(start_change.x.size(), model.num_dofs());
  CHECK_EQ(start_change.v.size(), model.num_dofs());
  RowMatrix dx = start_change.x, dv = start_change.v, columns(model.num_dofs(), kPaddedEntries);
  const auto add_material = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& w, RowMatrix& to) {
    columns.setZero();
    AddMaterialColumns(model, material, change, x, w, options.h, columns);
    to += columns.rowwise().sum();
  };
  RolloutResult rollout = CarryTangents(solver, material, start, options, add_material, dx, dv);
  return {std::move(rollout), {dx, dv}};
}

namespace {

// x0 += (∂g/∂x)ᵀ·λ and material += (∂g/∂p)ᵀ·λ of the step at x.
void AddStepAdjoint(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                    const Eigen::VectorXd& w, double h, const RowMatrix& lambda,
                    AdjointResult& result) {
  const ClothModel& model = solver.model();
  if (lambda.cols() == 1) {
    AdjStep(model, material, x, w, h, lambda, result.x0, result.material);
  } else {
    AddTransposeMultiply(model.pattern, solver.StepDerivative(material, x, w, h), lambda,
                         result.x0);
    AddMaterialGradient(model, material, x, w, h, lambda, result.material);
  }
}

}  // namespace

AdjointResult RolloutAdjoint(StepSolver& solver, const MaterialField& material,
                             const RolloutOptions& options, const Recording& recording,
                             const RowMatrix& seeds) {
  options.Check();
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), options.cancel);
  const ClothModel& model = solver.model();
  const int m = static_cast<int>(seeds.cols()), steps = static_cast<int>(recording.factor.size());
  CHECK_EQ(seeds.rows(), model.num_dofs());
  const Eigen::VectorXd mass = model.LumpedMass(material.density);
  AdjointResult result{RolloutStatus::kOk, MaterialGradient::Zero(material, m), seeds,
                       RowMatrix::Zero(seeds.rows(), m)};
  RowMatrix lambda(seeds.rows(), m);
  for (int k = steps - 1; k >= 0; --k) {
    const Eigen::VectorXd &x = recording.x[k], &w = recording.v[k + 1];
    if (Cancelled(options)) return {RolloutStatus::kCancelled, {}, {}, {}};
    lambda = result.v0 + options.h * result.x0;
    if (!recording.factor[k].empty()) {
      solver.linear().SolveSaved(recording.factor[k], lambda);
    } else if (solver.Factor(material, x, options.h)) {
      solver.linear().Solve(lambda);
    } else if (Cancelled(options)) {
      return {RolloutStatus::kCancelled, {}, {}, {}};
    } else {
      result.status = RolloutStatus::kNotPositiveDefinite;
      return result;
    }
    AddStepAdjoint(solver, material, x, w, options.h, lambda, result);
    result.v0 = mass.asDiagonal() * lambda;
  }
  return result;
}

}  // namespace drape
