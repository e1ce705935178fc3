// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/rollout.h"

#include <glog/logging.h>

#include <algorithm>
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
  if (!solver.Factor(material, state.x, h, &state.v))
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

// Keeps the state if it is the next frame. Returns whether it is.
bool KeepFrame(const RolloutOptions& options, RolloutResult& result) {
  const std::size_t next = result.frames.size();
  if (next == options.frames.size() || options.frames[next] != result.steps) return false;
  result.frames.push_back(result.end);
  return true;
}

bool Cancelled(const RolloutOptions& options) {
  return options.cancel != nullptr && options.cancel->load(std::memory_order_relaxed);
}

}  // namespace

void RolloutOptions::Check() const {
  CHECK_GT(h, 0.0) << "RolloutOptions::h";
  CHECK_GE(steps, 0) << "RolloutOptions::steps";
  for (std::size_t k = 0; k < frames.size(); ++k)
    CHECK(frames[k] >= 0 && frames[k] <= steps && (k == 0 || frames[k - 1] < frames[k]))
        << "RolloutOptions::frames[" << k << "] = " << frames[k];
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
  if (result.status == RolloutStatus::kOk) KeepFrame(options, result);
  bool blocked = false;
  while (result.status == RolloutStatus::kOk && result.steps < options.steps) {
    result.status = Cancelled(options)
                        ? RolloutStatus::kCancelled
                        : AdvanceOneStep(solver, material, mass, options.h, result.end, &blocked);
    if (recording != nullptr && blocked) result.status = RolloutStatus::kBlocked;
    if (result.status != RolloutStatus::kOk) break;
    if (recording != nullptr) Record(solver.linear(), options, result, *recording);
    ++result.steps;
    KeepFrame(options, result);
  }
  if (recording != nullptr) recording->factor.resize(result.steps);
  return result;
}

namespace {

// dv ← (M + ∂g/∂v)·dv + ∂g/∂x·dx, both of the air alone.
void CarryVelocity(const ClothModel& model, const MaterialField& material,
                   const Eigen::VectorXd& mass, const MovingStep& step, const RowMatrix& dx,
                   RowMatrix& dv) {
  if (material.dynamics.air_drag == 0.0) {
    dv = mass.asDiagonal() * dv;
    return;
  }
  RowMatrix sum = mass.asDiagonal() * dv;
  AddAirTangent(model, material, step, dx, dv, sum);
  dv = std::move(sum);
}

// Rollout that carries columns of ∂(state)/∂p along, shape [3V, m] each, from what they are at the
// start. add_parameters(step, dv): dv += ∂g/∂p of the step; at_frame(frames): sees the columns at
// the last of the frames so far.
template <class AddParameters, class AtFrame>
RolloutResult CarryTangents(StepSolver& solver, const MaterialField& material, const State& start,
                            const RolloutOptions& options, const AddParameters& add_parameters,
                            const AtFrame& at_frame, FrameTangent& columns) {
  options.Check();
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), options.cancel);
  const ClothModel& model = solver.model();
  const Eigen::VectorXd mass = model.LumpedMass(material.density);
  auto& [dx, dv] = columns;
  RolloutResult rollout = Begin(solver, start);
  const auto see = [&] {
    if (KeepFrame(options, rollout)) at_frame(rollout.frames);
  };
  if (rollout.status == RolloutStatus::kOk) see();
  Eigen::VectorXd before;
  while (rollout.status == RolloutStatus::kOk && rollout.steps < options.steps) {
    const Eigen::VectorXd& x = rollout.end.x;
    before = rollout.end.v;
    rollout.status = Cancelled(options)
                         ? RolloutStatus::kCancelled
                         : SolveVelocity(solver, material, mass, options.h, rollout.end);
    if (rollout.status == RolloutStatus::kOk && BlockMoves(solver, options.h, rollout.end))
      rollout.status = RolloutStatus::kBlocked;
    if (rollout.status != RolloutStatus::kOk) break;
    const Eigen::VectorXd& w = rollout.end.v;
    const MovingStep step{x, before, w, options.h};
    CarryVelocity(model, material, mass, step, dx, dv);
    AddMultiply(model.pattern, solver.StepDerivative(material, x, w, options.h), dx, dv);
    add_parameters(step, dv);
    solver.linear().Solve(dv);
    dx += options.h * dv;
    rollout.end.x += options.h * w;
    ++rollout.steps;
    see();
  }
  return rollout;
}

// The columns of a tangent at the start: the material's, those of `more`, and padding to rows of
// whole vector registers. *count: without the padding.
FrameTangent StartColumns(const ClothModel& model, const TangentOptions& more, int* count) {
  const int first = kMaterialEntries + (more.dynamics ? kDynamicsEntries : 0);
  const auto q = static_cast<int>(std::max(more.start_dx.cols(), more.start_dv.cols()));
  *count = first + q;
  const int registers = (*count + kPaddedEntries - kMaterialEntries + 3) / 4;
  const RowMatrix zero = RowMatrix::Zero(model.num_dofs(), 4 * registers);
  FrameTangent columns{zero, zero};
  const auto fill = [&](const RowMatrix& from, RowMatrix& to) {
    if (from.size() == 0) return;
    CHECK_EQ(from.rows(), model.num_dofs()) << "TangentOptions";
    CHECK_EQ(from.cols(), q) << "TangentOptions";
    to.middleCols(first, q) = from;
  };
  fill(more.start_dx, columns.dx);
  fill(more.start_dv, columns.dv);
  return columns;
}

}  // namespace

TangentResult RolloutTangent(StepSolver& solver, const MaterialField& material,
                             const MaterialField& weight, const State& start,
                             const RolloutOptions& options, const TangentOptions& more) {
  const ClothModel& model = solver.model();
  int count = 0;
  FrameTangent columns = StartColumns(model, more, &count);
  const auto add_parameters = [&](const MovingStep& step, RowMatrix& to) {
    AddMaterialColumns(model, material, weight, step.x, step.w, step.h, to);
    if (more.dynamics)
      to.middleCols<kDynamicsEntries>(kMaterialEntries) += DynamicsColumns(model, material, step);
  };
  TangentResult result;
  const auto at_frame = [&](const std::vector<State>& frames) {
    const auto dx = columns.dx.leftCols(count), dv = columns.dv.leftCols(count);
    if (more.on_frame)
      more.on_frame(static_cast<int>(frames.size()) - 1, frames.back(), dx, dv);
    else
      result.frames.push_back({dx, dv});
  };
  result.rollout =
      CarryTangents(solver, material, start, options, add_parameters, at_frame, columns);
  result.dx = columns.dx.leftCols(count);
  result.dv = columns.dv.leftCols(count);
  return result;
}

JvpResult RolloutJvp(StepSolver& solver, const MaterialField& material, const MaterialField& change,
                     const State& start, const State& start_change, const RolloutOptions& options,
                     std::span<const double> dynamics_change) {
  const ClothModel& model = solver.model();
  CHECK_EQ(start_change.x.size(), model.num_dofs());
  CHECK_EQ(start_change.v.size(), model.num_dofs());
  const Eigen::Map<const Eigen::VectorXd> numbers(
      dynamics_change.data(), static_cast<Eigen::Index>(dynamics_change.size()));
  CHECK(numbers.size() == 0 || numbers.size() == kDynamicsEntries) << numbers.size();
  FrameTangent moved{start_change.x, start_change.v};
  RowMatrix columns(model.num_dofs(), kPaddedEntries);
  const auto add_parameters = [&](const MovingStep& step, RowMatrix& to) {
    columns.setZero();
    AddMaterialColumns(model, material, change, step.x, step.w, step.h, columns);
    to += columns.rowwise().sum();
    if (numbers.size() > 0) to += DynamicsColumns(model, material, step) * numbers;
  };
  JvpResult result;
  const auto at_frame = [&](const std::vector<State>&) {
    result.frames.push_back({moved.dx, moved.dv});
  };
  result.rollout = CarryTangents(solver, material, start, options, add_parameters, at_frame, moved);
  result.change = {moved.dx, moved.dv};
  return result;
}

namespace {

// x0 += (∂g/∂x)ᵀ·λ, material += (∂g/∂p)ᵀ·λ and v0 = (M + ∂g/∂v)ᵀ·λ of the step.
void AddStepAdjoint(StepSolver& solver, const MaterialField& material, const MovingStep& step,
                    const Eigen::VectorXd& mass, const RowMatrix& lambda, AdjointResult& result) {
  const ClothModel& model = solver.model();
  const auto& [x, v, w, h] = step;
  const bool wants_dynamics = result.dynamics.size() > 0;
  if (lambda.cols() == 1) {
    const double stiffness_work =
        AdjStep(model, material, x, w, h, lambda, result.x0, result.material);
    if (wants_dynamics)
      result.dynamics.col(0) += DynamicsAdjoint(model, material, step, lambda, stiffness_work);
  } else {
    AddTransposeMultiply(model.pattern, solver.StepDerivative(material, x, w, h), lambda,
                         result.x0);
    AddMaterialGradient(model, material, x, w, h, lambda, result.material);
    if (wants_dynamics)
      result.dynamics += DynamicsColumns(model, material, step).transpose() * lambda;
  }
  result.v0 = mass.asDiagonal() * lambda;
  if (material.dynamics.air_drag != 0.0)
    AddAirAdjoint(model, material, step, lambda, result.x0, result.v0);
}

// Adds the seeds of the state after `step` steps if it is a frame.
void AddFrameSeeds(const RolloutOptions& options, const AdjointOptions& more, int step,
                   AdjointResult& result) {
  if (more.frames.empty()) return;
  const auto at = std::lower_bound(options.frames.begin(), options.frames.end(), step);
  if (at == options.frames.end() || *at != step) return;
  const FrameSeeds& seeds = more.frames[at - options.frames.begin()];
  const auto add = [](const RowMatrix& seed, RowMatrix& to) {
    if (seed.size() == 0) return;
    CHECK(seed.rows() == to.rows() && seed.cols() == to.cols()) << "FrameSeeds";
    to += seed;
  };
  add(seeds.x, result.x0);
  add(seeds.v, result.v0);
}

// λ ← A⁻¹·λ of step k; its status.
RolloutStatus SolveBack(StepSolver& solver, const MaterialField& material,
                        const RolloutOptions& options, const Recording& recording, int k,
                        RowMatrix& lambda) {
  if (!recording.factor[k].empty())
    solver.linear().SolveSaved(recording.factor[k], lambda);
  else if (solver.Factor(material, recording.x[k], options.h, &recording.v[k]))
    solver.linear().Solve(lambda);
  else
    return Cancelled(options) ? RolloutStatus::kCancelled : RolloutStatus::kNotPositiveDefinite;
  return RolloutStatus::kOk;
}

}  // namespace

AdjointResult RolloutAdjoint(StepSolver& solver, const MaterialField& material,
                             const RolloutOptions& options, const Recording& recording,
                             const RowMatrix& seeds, const AdjointOptions& more) {
  options.Check();
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), options.cancel);
  const ClothModel& model = solver.model();
  const int m = static_cast<int>(seeds.cols()), steps = static_cast<int>(recording.factor.size());
  CHECK_EQ(seeds.rows(), model.num_dofs());
  CHECK(more.frames.empty() || more.frames.size() == options.frames.size()) << "AdjointOptions";
  const Eigen::VectorXd mass = model.LumpedMass(material.density);
  AdjointResult result{RolloutStatus::kOk, MaterialGradient::Zero(material, m), seeds,
                       RowMatrix::Zero(seeds.rows(), m)};
  if (more.dynamics) result.dynamics = RowMatrix::Zero(kDynamicsEntries, m);
  RowMatrix lambda(seeds.rows(), m);
  for (int k = steps - 1; k >= 0; --k) {
    if (Cancelled(options)) return {RolloutStatus::kCancelled, {}, {}, {}};
    AddFrameSeeds(options, more, k + 1, result);
    lambda = result.v0 + options.h * result.x0;
    result.status = SolveBack(solver, material, options, recording, k, lambda);
    if (result.status == RolloutStatus::kCancelled) return {result.status, {}, {}, {}};
    if (result.status != RolloutStatus::kOk) return result;
    AddStepAdjoint(solver, material,
                   {recording.x[k], recording.v[k], recording.v[k + 1], options.h}, mass, lambda,
                   result);
  }
  AddFrameSeeds(options, more, 0, result);
  return result;
}

}  // namespace drape
