// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/drape_batch.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/run_control.h"
#include "physics/util/text_format.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

void RequireShape(const RowMatrix& array, const std::string& name, Eigen::Index rows,
                  Eigen::Index columns) {
  const auto shape = [](Eigen::Index b, Eigen::Index n) {
    return Format("[%d, %d]", static_cast<int>(b), static_cast<int>(n));
  };
  if (array.rows() != rows || array.cols() != columns)
    throw InputError(name, "found the shape " + shape(array.rows(), array.cols()) + ", expected " +
                               shape(rows, columns));
  if (!array.allFinite()) throw InputError(name, "found a number that is not finite");
}

// The numbers of DrapeInputs::dynamics.
constexpr int kDynamics = kDynamicsEntries - kByMassDamping;

Dynamics MakeDynamics(const Eigen::VectorXd& numbers) {
  for (const FreeNumber each :
       {FreeNumber::kMassDamping, FreeNumber::kStiffnessDamping, FreeNumber::kAirDrag})
    if (const double number = numbers[int(each) - kByMassDamping]; number < 0.0)
      throw InputError("dynamics",
                       Format("found %g for %s, expected 0 or more", number, ToString(each)));
  const auto wind = numbers.tail<3>();
  return {numbers[0], numbers[1], numbers[2], {wind[0], wind[1], wind[2]}};
}

void RequireFrames(const DrapeBatchOptions& options) {
  if (!options.frames.empty() && options.solve_mode != SolveMode::kDynamic)
    throw InputError("frames", "found some of an equilibrium, expected solve dynamic");
  int before = -1;
  for (const int frame : options.frames) {
    if (frame <= before || frame > options.steps)
      throw InputError("frames",
                       Format("found %d, expected ascending numbers of steps from 0 to %d", frame,
                              options.steps));
    before = frame;
  }
}

}  // namespace

DrapeBatch::DrapeBatch(Backend& backend, const std::vector<MaterialField>& materials,
                       DrapeInputs inputs, const DrapeBatchOptions& options)
    : backend_(backend), options_(options) {
  if (!(options.h > 0.0 && std::isfinite(options.h)))
    throw InputError("h", Format("found a time step of %g s, expected more than 0", options.h));
  if (options.steps < 0)
    throw InputError("steps", Format("found %d, expected 0 or more", options.steps));
  RequireFrames(options);
  const Eigen::Index count = inputs.log_factors.rows(), factors = inputs.log_factors.cols();
  if (count == 0) throw InputError("drapes", "found 0, expected 1 or more");
  const auto tying =
      ParseName<ParameterTying>(std::to_string(factors), "number of factors of a drape");
  if (inputs.start.size() == 0)
    inputs.start = backend.model().mesh.rest_x.transpose().replicate(count, 1);
  const bool has_dynamics = inputs.dynamics.size() > 0;
  FillAndCheck(count, factors, &inputs);
  if (materials.size() != 1 && static_cast<Eigen::Index>(materials.size()) != count)
    throw InputError("materials", Format("found %zu, expected 1 or %d, the number of drapes",
                                         materials.size(), static_cast<int>(count)));
  for (Eigen::Index i = 0; i < count; ++i) {
    maps_.emplace_back(materials[materials.size() == 1 ? 0 : i], tying);
    materials_.push_back(maps_.back().Material(inputs.log_factors.row(i)));
    if (has_dynamics) materials_.back().dynamics = MakeDynamics(inputs.dynamics.row(i));
    starts_.push_back({inputs.start.row(i), inputs.velocity.row(i)});
  }
}

void DrapeBatch::FillAndCheck(Eigen::Index count, Eigen::Index factors, DrapeInputs* inputs) const {
  const Eigen::Index dofs = backend_.model().num_dofs();
  const auto check = [count](RowMatrix& array, const char* name, Eigen::Index columns) {
    if (array.size() == 0) array = RowMatrix::Zero(count, columns);
    RequireShape(array, name, count, columns);
  };
  check(inputs->log_factors, "log_factors", factors);
  check(inputs->start, "start", dofs);
  check(inputs->velocity, "velocity", dofs);
  check(inputs->dynamics, "dynamics", kDynamics);
}

std::vector<RolloutInput> DrapeBatch::ListInputs() const {
  std::vector<RolloutInput> inputs;
  for (int i = 0; i < size(); ++i) inputs.push_back({&materials_[i], &starts_[i]});
  return inputs;
}

RolloutOptions DrapeBatch::Steps(const std::atomic<bool>* cancel) const {
  return {.h = options_.h, .steps = options_.steps, .cancel = cancel, .frames = options_.frames};
}

std::vector<int> DrapeBatch::ListFound() const {
  std::vector<int> found;
  for (std::size_t i = 0; i < ends_.size(); ++i)
    if (ends_[i].x.size() > 0) found.push_back(static_cast<int>(i));
  return found;
}

void DrapeBatch::Run(const std::atomic<bool>* cancel) {
  status_.clear();
  ends_.assign(size(), {});
  frames_.assign(size(), {});
  if (options_.solve_mode == SolveMode::kDynamic) {
    auto rollouts =
        backend_.Rollouts(ListInputs(), Steps(cancel), options_.record ? &recordings_ : nullptr);
    for (int i = 0; i < size(); ++i) {
      status_.emplace_back(ToString(rollouts[i].status));
      if (rollouts[i].status != RolloutStatus::kOk) continue;
      ends_[i] = std::move(rollouts[i].end);
      frames_[i] = std::move(rollouts[i].frames);
    }
    return;
  }
  auto drapes =
      Settle(backend_, ListInputs(), {.steps = Steps(cancel), .equilibrium = {.cancel = cancel}});
  for (int i = 0; i < size(); ++i) {
    EquilibriumResult& rest = drapes[i].rest;
    status_.emplace_back(drapes[i].steps == RolloutStatus::kOk ? ToString(rest.status)
                                                               : ToString(drapes[i].steps));
    if (drapes[i].IsUsable(SolveMode::kStatic))
      ends_[i] = {rest.x, Eigen::VectorXd::Zero(rest.x.size())};
  }
}

std::vector<bool> DrapeBatch::IsFound() const {
  std::vector<bool> is_found(size(), false);
  for (const int i : ListFound()) is_found[i] = true;
  return is_found;
}

RowMatrix DrapeBatch::NotANumber(Eigen::Index columns) const {
  return RowMatrix::Constant(size(), columns, std::numeric_limits<double>::quiet_NaN());
}

RowMatrix DrapeBatch::Positions() const {
  RowMatrix x = NotANumber(backend_.model().num_dofs());
  for (const int i : ListFound()) x.row(i) = ends_[i].x;
  return x;
}

RowMatrix DrapeBatch::Velocities() const {
  RowMatrix v = NotANumber(backend_.model().num_dofs());
  for (const int i : ListFound()) v.row(i) = ends_[i].v;
  return v;
}

Eigen::Index DrapeBatch::frame_columns() const {
  return std::ssize(options_.frames) * backend_.model().num_dofs();
}

DrapeFrames DrapeBatch::StackFrames(const std::vector<std::vector<State>>& frames) const {
  DrapeFrames all{NotANumber(frame_columns()), NotANumber(frame_columns())};
  const Eigen::Index dofs = backend_.model().num_dofs();
  for (int i = 0; i < size(); ++i)
    for (std::size_t k = 0; k < frames[i].size(); ++k) {
      const Eigen::Index column = static_cast<Eigen::Index>(k) * dofs;
      all.x.row(i).segment(column, dofs) = frames[i][k].x;
      all.v.row(i).segment(column, dofs) = frames[i][k].v;
    }
  return all;
}

DrapeFrames DrapeBatch::Frames() const { return StackFrames(frames_); }

Eigen::VectorXd DrapeBatch::Residuals() const {
  Eigen::VectorXd residuals = NotANumber(1);
  for (const int i : ListFound())
    residuals[i] = ForceResidual(backend_.model(), materials_[i], ends_[i].x);
  return residuals;
}

RowMatrix DrapeBatch::Read(const Readout& readout) const {
  RowMatrix all = NotANumber(readout.size());
  Eigen::VectorXd r;
  for (const int i : ListFound())
    if (readout.Read(ends_[i].x, &r, nullptr)) all.row(i) = r;
  return all;
}

Eigen::VectorXd DrapeBatch::Move(int i, const DrapeInputs& change, StepSolver& solver,
                                 const std::atomic<bool>* cancel) const {
  if (options_.solve_mode == SolveMode::kStatic) {
    const MaterialField entries = maps_[i].Jvp(materials_[i], change.log_factors.row(i));
    Eigen::VectorXd dx;
    const bool moves = EquilibriumJvpColumn(solver, materials_[i], entries, ends_[i].x, &dx);
    return moves ? dx : Eigen::VectorXd();
  }
  JvpResult jvp = MoveInSteps(i, change, solver, cancel);
  return jvp.rollout.status == RolloutStatus::kOk ? std::move(jvp.change.x) : Eigen::VectorXd();
}

JvpResult DrapeBatch::MoveInSteps(int i, const DrapeInputs& change, StepSolver& solver,
                                  const std::atomic<bool>* cancel) const {
  Eigen::VectorXd dynamics = Eigen::VectorXd::Zero(kDynamicsEntries);
  dynamics.tail(kDynamics) = change.dynamics.row(i);
  std::span<const double> given;  // changes of them alone cost time
  if (!dynamics.isZero(0.0)) given = {dynamics.data(), kDynamicsEntries};
  return RolloutJvp(solver, materials_[i], maps_[i].Jvp(materials_[i], change.log_factors.row(i)),
                    starts_[i], {change.start.row(i), change.velocity.row(i)}, Steps(cancel),
                    given);
}

void DrapeBatch::ForEachFound(const std::function<void(int i, StepSolver& solver)>& use,
                              const std::atomic<bool>* cancel) const {
  // The model of a backend lives as long as the backend.
  const std::shared_ptr<const ClothModel> model(std::shared_ptr<void>(), &backend_.model());
  const StepSolver solver(model);
  const std::vector<int> found = ListFound();
  RunInThreads(static_cast<int>(found.size()), backend_.threads(), cancel, [&](int k) {
    StepSolver own = solver.Clone();
    use(found[k], own);
  });
}

RowMatrix DrapeBatch::Jvp(const Readout& readout, DrapeInputs change,
                          const std::atomic<bool>* cancel) const {
  FillAndCheck(size(), maps_[0].size(), &change);
  RowMatrix all = NotANumber(readout.size());
  const auto add = [&](int i, StepSolver& solver) {
    const Eigen::VectorXd dx = Move(i, change, solver, cancel);
    Eigen::VectorXd r;
    ReadoutJacobian dr_dx;
    if (dx.size() > 0 && readout.Read(ends_[i].x, &r, &dr_dx)) all.row(i) = dr_dx * dx;
  };
  ForEachFound(add, cancel);
  return all;
}

DrapeFrames DrapeBatch::FrameJvp(DrapeInputs change, const std::atomic<bool>* cancel) const {
  FillAndCheck(size(), maps_[0].size(), &change);
  std::vector<std::vector<State>> changes(size());
  const auto add = [&](int i, StepSolver& solver) {
    JvpResult jvp = MoveInSteps(i, change, solver, cancel);
    if (jvp.rollout.status == RolloutStatus::kOk) changes[i] = std::move(jvp.frames);
  };
  if (options_.solve_mode == SolveMode::kDynamic) ForEachFound(add, cancel);
  return StackFrames(changes);
}

DrapeInputs DrapeBatch::NoGradient() const {
  const Eigen::Index dofs = backend_.model().num_dofs();
  return {NotANumber(maps_[0].size()), NotANumber(dofs), NotANumber(dofs), NotANumber(kDynamics)};
}

DrapeInputs DrapeBatch::Vjp(const Readout& readout, const RowMatrix& dL_dr,
                            const std::atomic<bool>* cancel) const {
  RequireShape(dL_dr, "cotangent", size(), readout.size());
  std::vector<int> readable;
  std::vector<RowMatrix> dL_dx(size(), RowMatrix::Zero(backend_.model().num_dofs(), 1));
  for (const int i : ListFound()) {
    Eigen::VectorXd r;
    ReadoutJacobian dr_dx;
    if (!readout.Read(ends_[i].x, &r, &dr_dx)) continue;
    readable.push_back(i);
    dL_dx[i] = dr_dx.transpose() * dL_dr.row(i).transpose();
  }
  DrapeInputs gradient = NoGradient();
  if (options_.solve_mode == SolveMode::kDynamic) {
    AddAdjoints(readable, dL_dx, {}, cancel, &gradient);
  } else {
    AddEquilibriumAdjoints(readable, dL_dx, &gradient);
  }
  return gradient;
}

DrapeInputs DrapeBatch::FrameVjp(DrapeFrames dL, const std::atomic<bool>* cancel) const {
  const Eigen::Index dofs = backend_.model().num_dofs();
  for (RowMatrix* each : {&dL.x, &dL.v}) {
    if (each->size() == 0) *each = RowMatrix::Zero(size(), frame_columns());
    RequireShape(*each, "cotangent", size(), frame_columns());
  }
  std::vector<AdjointOptions> by_frames(size());
  for (int i = 0; i < size(); ++i)
    for (Eigen::Index k = 0; k < std::ssize(options_.frames); ++k)
      by_frames[i].frames.push_back({dL.x.row(i).segment(k * dofs, dofs).transpose(),
                                     dL.v.row(i).segment(k * dofs, dofs).transpose()});
  DrapeInputs gradient = NoGradient();
  if (options_.solve_mode == SolveMode::kDynamic)
    AddAdjoints(ListFound(), std::vector<RowMatrix>(size(), RowMatrix::Zero(dofs, 1)),
                std::move(by_frames), cancel, &gradient);
  return gradient;
}

void DrapeBatch::AddAdjoints(const std::vector<int>& members, const std::vector<RowMatrix>& dL_dx,
                             std::vector<AdjointOptions> by_frames, const std::atomic<bool>* cancel,
                             DrapeInputs* gradient) const {
  std::vector<RolloutInput> inputs = ListInputs();
  std::vector<Recording> again;
  std::vector<bool> has_derivative(size(), true);
  if (!options_.record) {
    const auto rollouts = backend_.Rollouts(inputs, Steps(cancel), &again);
    for (int i = 0; i < size(); ++i) has_derivative[i] = rollouts[i].status == RolloutStatus::kOk;
  }
  by_frames.resize(size());
  // The kernels have no adjoint by dynamics in a scene without stretch.
  const bool with_dynamics = backend_.model().scene.stretch || backend_.name() == "cpu";
  for (int i = 0; i < size(); ++i) {
    by_frames[i].dynamics = with_dynamics;
    inputs[i].adjoint = &by_frames[i];
  }
  const auto adjoints =
      backend_.Adjoints(inputs, options_.record ? recordings_ : again, dL_dx, Steps(cancel));
  for (const int i : members) {
    if (!has_derivative[i] || adjoints[i].status != RolloutStatus::kOk) continue;
    gradient->log_factors.row(i) = maps_[i].Vjp(materials_[i], adjoints[i].material).transpose();
    gradient->start.row(i) = adjoints[i].x0.transpose();
    gradient->velocity.row(i) = adjoints[i].v0.transpose();
    if (with_dynamics)
      gradient->dynamics.row(i) = adjoints[i].dynamics.bottomRows(kDynamics).transpose();
  }
}

void DrapeBatch::AddEquilibriumAdjoints(const std::vector<int>& members,
                                        const std::vector<RowMatrix>& dL_dx,
                                        DrapeInputs* gradient) const {
  std::vector<RolloutInput> inputs;
  std::vector<RowMatrix> seeds;
  for (const int i : members) {
    inputs.push_back({&materials_[i], &ends_[i]});
    seeds.push_back(dL_dx[i]);
  }
  const auto found = backend_.EquilibriumAdjoints(inputs, seeds);
  for (std::size_t k = 0; k < members.size(); ++k) {
    const int i = members[k];
    if (!found[k]) continue;
    gradient->log_factors.row(i) = maps_[i].Vjp(materials_[i], *found[k]).transpose();
    // A start moves no equilibrium; it can only lead to another.
    gradient->start.row(i).setZero();
    gradient->velocity.row(i).setZero();
    gradient->dynamics.row(i).setZero();
  }
}

}  // namespace drape
