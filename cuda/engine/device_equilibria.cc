// SPDX-License-Identifier: Apache-2.0
// Newton's method for a batch of drapes at rest: the decisions are those of
// physics/simulation/statics/statics.h, one NewtonControl a rollout, the shapes stay on the device.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cuda/engine/implicit_workspace.h"
#include "cuda/kernels/statics/statics_kernels.h"
#include "physics/simulation/statics/newton_control.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {

class BatchNewton {
 public:
  BatchNewton(DeviceEngine& engine, std::span<const RolloutInput> batch,
              const EquilibriumOptions& options)
      : engine_(engine),
        cloth_(engine.cloth_->view()),
        options_(options),
        count_(static_cast<int>(batch.size())),
        stream_(engine.streams_->main()),
        materials_(Fields(batch)) {
    const auto take = [&](Arena& arena, int n) { Take(arena, n); };
    Arena arena = engine_.MakeRoom(count_, take);
    take(arena, count_);
    engine_.UploadStarts(batch, here_.x, nullptr);
    std::vector<int> all(count_);
    for (int r = 0; r < count_; ++r) all[r] = r;
    for (const RolloutInput& input : batch)
      weight_.push_back(CharacteristicForce(engine_.cloth_->model(), *input.material));
    const std::vector<Measured> start = Measure(all);
    for (int r = 0; r < count_; ++r)
      controls_.emplace_back(options, start[r].residual, start[r].energy);
    measured_ = best_measured_ = start_ = start;
    Act(all, std::vector<ShapeAction>(count_, ShapeAction::kKeep));
  }

  static void TakeAll(Arena& arena, const DeviceCloth& cloth, int n) {
    BatchNewton::Layout layout;
    layout.Take(arena, cloth, n);
  }

  void Run(std::span<EquilibriumResult> results) {
    std::vector<int> converged;
    std::vector<EquilibriumStatus> status(count_, EquilibriumStatus::kNotConverged);
    std::vector<int> active(count_);
    for (int r = 0; r < count_; ++r) active[r] = r;
    while (!active.empty()) {
      std::vector<int> stepping;
      for (const int r : active) switch (controls_[r].Next()) {
          case NewtonNext::kStep:
            stepping.push_back(r);
            break;
          case NewtonNext::kConverged:
            converged.push_back(r);
            break;
          case NewtonNext::kCancelled:
            status[r] = EquilibriumStatus::kCancelled;
            break;
          case NewtonNext::kGiveUp:
            break;
        }
      active = std::move(stepping);
      if (!active.empty()) Step(active);
    }
    Conclude(converged, &status);
    Collect(converged, status, results);
  }

 private:
  struct Measured {
    double residual, energy;
  };
  // By rollout, but for the workspace.
  struct Layout {
    DeviceEngine::ImplicitWorkspace work;
    Shapes here, best;
    StretchStress<double>* geometric;
    double *dx, *scale, *move, *sums;
    int* rollout;
    ShapeAction* action;

    void Take(Arena& arena, const DeviceCloth& cloth, int n) {
      const std::size_t dofs = std::size_t{1} * n * cloth.view().num_dofs();
      const std::size_t faces = std::size_t{1} * n * cloth.view().num_faces;
      work = DeviceEngine::ImplicitWorkspace::Take(arena, cloth, n, 1, false);
      for (Shapes* shapes : {&here, &best})
        *shapes = {arena.Take<double>(dofs), arena.Take<double>(dofs),
                   arena.Take<StretchStress<double>>(faces)};
      geometric = arena.Take<StretchStress<double>>(faces);
      dx = arena.Take<double>(dofs);
      scale = arena.Take<double>(n);
      move = arena.Take<double>(n);
      sums = arena.Take<double>(2 * n);
      rollout = arena.Take<int>(n);
      action = arena.Take<ShapeAction>(n);
    }
  };

  static std::vector<const MaterialField*> Fields(std::span<const RolloutInput> batch) {
    std::vector<const MaterialField*> fields;
    for (const RolloutInput& input : batch) fields.push_back(input.material);
    return fields;
  }

  void Take(Arena& arena, int n) {
    layout_.Take(arena, *engine_.cloth_, n);
    here_ = layout_.here;
    best_ = layout_.best;
  }

  // Slots of these rollouts at their present shapes.
  ShapeBatch CountSlots(const std::vector<int>& rollouts) {
    CopyToDevice<int>(rollouts, layout_.rollout);
    const int slots = static_cast<int>(rollouts.size());
    return {slots, slots, layout_.rollout, materials_.views(), here_.x};
  }

  // Forces, stresses, ‖f‖ / weight and energy of the present shapes, in the order of `rollouts`.
  std::vector<Measured> Measure(const std::vector<int>& rollouts) {
    const ShapeBatch shapes = CountSlots(rollouts);
    const StepRecords& records = layout_.work.step.records;
    const Law& law = engine_.cloth_->law();
    LaunchElementRecords(cloth_, shapes, law, records, stream_);
    LaunchGatherForce(cloth_, shapes, records, here_.force, stream_);
    LaunchMeasure(cloth_, shapes, law, records.faces, records.hinges, here_, layout_.sums, stream_);
    engine_.streams_->Synchronize();
    std::vector<double> sums(2 * rollouts.size());
    CopyToHost<double>(layout_.sums, sums);
    std::vector<Measured> measured;
    for (std::size_t s = 0; s < rollouts.size(); ++s)
      measured.push_back({std::sqrt(sums[2 * s]) / weight_[rollouts[s]], sums[2 * s + 1]});
    return measured;
  }

  void Step(const std::vector<int>& active) {
    const std::vector<int> stepping = FindSteps(active);
    if (stepping.empty()) return;
    const ShapeBatch shapes = CountSlots(stepping);
    double* dx = layout_.work.step.solution;
    LaunchGatherRows(cloth_.num_dofs(), layout_.rollout, layout_.dx, dx, shapes.slots, stream_);
    LaunchLargestMove(cloth_, dx, layout_.move, shapes.slots, stream_);
    engine_.streams_->Synchronize();
    std::vector<double> scale(shapes.slots);
    CopyToHost<double>(layout_.move, scale);
    for (int s = 0; s < shapes.slots; ++s) scale[s] = controls_[stepping[s]].Scale(scale[s]);
    CopyToDevice<double>(scale, layout_.scale);
    LaunchMoveShapes(cloth_, shapes, engine_.cloth_->law(), dx, layout_.scale, layout_.geometric,
                     here_.x, stream_);
    const std::vector<Measured> measured = Measure(stepping);
    std::vector<ShapeAction> actions;
    for (int s = 0; s < shapes.slots; ++s) actions.push_back(Judge(stepping[s], measured[s]));
    Act(stepping, actions);
  }

  // Newton steps of the rollouts in layout_.dx; those whose stiffness no shift made positive
  // definite are left out.
  std::vector<int> FindSteps(const std::vector<int>& active) {
    std::vector<int> pending = active, found;
    std::vector<double> mu;
    for (const int r : active) mu.push_back(controls_[r].FirstShift());
    while (!pending.empty()) {
      const std::vector<int> failed = TrySteps(pending, mu);
      std::vector<int> again;
      std::vector<double> raised;
      for (std::size_t s = 0; s < pending.size(); ++s) {
        if (failed[s] == 0) {
          found.push_back(pending[s]);
        } else if (const auto next = controls_[pending[s]].NextShift()) {
          again.push_back(pending[s]);
          raised.push_back(*next);
        }
      }
      pending = std::move(again);
      mu = std::move(raised);
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  std::vector<int> TrySteps(const std::vector<int>& rollouts, const std::vector<double>& mu) {
    DeviceEngine::ImplicitWorkspace& w = layout_.work;
    const ShapeBatch shapes = CountSlots(rollouts);
    const int dofs = cloth_.num_dofs();
    CopyToDevice<double>(mu, w.mu);
    engine_.Clear(w.step.failed, shapes.slots * sizeof(int));
    engine_.Clear(w.step.v, sizeof(double) * shapes.slots * dofs);
    LaunchDerivativeRecords(cloth_, shapes, engine_.cloth_->law(), w.step.v, 1.0, w.derivatives,
                            stream_);
    LaunchGatherStiffness(cloth_, shapes, w.derivatives,
                          {layout_.geometric, here_.stress, w.mu, options_.shift.length},
                          w.step.matrix, stream_);
    LaunchGatherRows(dofs, layout_.rollout, here_.force, w.step.rhs, shapes.slots, stream_);
    engine_.cloth_->multifrontal().FactorAndSolve(engine_.FactorFrom(w.step, 0), w.step.rhs,
                                                  w.step.solution, shapes.slots, shapes.slots,
                                                  stream_);
    LaunchScatterRows(dofs, layout_.rollout, w.step.solution, layout_.dx, shapes.slots, stream_);
    engine_.streams_->Synchronize();
    std::vector<int> failed(shapes.slots);
    CopyToHost<int>(w.step.failed, failed);
    return failed;
  }

  ShapeAction Judge(int r, const Measured& measured) {
    measured_[r] = measured;
    switch (controls_[r].Judge(measured.residual, measured.energy)) {
      case NewtonVerdict::kNonMonotone:
        return ShapeAction::kGoOn;
      case NewtonVerdict::kAccept:
        best_measured_[r] = measured;
        return ShapeAction::kKeep;
      case NewtonVerdict::kRejectStep:
        measured_[r] = best_measured_[r];
        break;
    }
    return ShapeAction::kRejectStep;
  }

  void Act(const std::vector<int>& rollouts, const std::vector<ShapeAction>& actions) {
    const ShapeBatch shapes = CountSlots(rollouts);
    CopyToDevice<ShapeAction>(actions, layout_.action);
    LaunchShapeAction(cloth_, shapes, layout_.action, here_, best_, layout_.geometric, stream_);
    engine_.streams_->Synchronize();
  }

  // The status of the rollouts at rest: Stiffness::Factor and Asymmetry.
  void Conclude(const std::vector<int>& converged, std::vector<EquilibriumStatus>* status) {
    if (converged.empty()) return;
    DeviceEngine::ImplicitWorkspace& w = layout_.work;
    const ShapeBatch shapes = CountSlots(converged);
    const int dofs = cloth_.num_dofs(), slots = shapes.slots;
    engine_.FactorStiffness(w, shapes);
    std::vector<double> directions(std::size_t{1} * slots * dofs), radius(slots);
    const RowMatrix start = AsymmetryStart(dofs);
    for (int s = 0; s < slots; ++s)
      engine_.cloth_->ToEliminationOrder(start.data(), 1, 1,
                                         directions.data() + std::size_t{1} * s * dofs);
    CopyToDevice<double>(directions, w.x);
    engine_.Clear(w.rhs, sizeof(double) * slots * dofs);
    for (int round = 0; round < kAsymmetryRounds; ++round) {
      LaunchMultiply(cloth_, w.blocks, false, w.x, w.rhs, 1, slots, stream_);
      engine_.cloth_->multifrontal().Solve(w.step.factor, w.rhs, w.rhs, w.vectors, 1, slots,
                                           stream_);
      LaunchPowerStep(dofs, w.rhs, w.x, w.dots, slots, stream_);
    }
    engine_.streams_->Synchronize();
    CopyToHost<double>(w.dots, radius);
    std::vector<int> failed(slots);
    CopyToHost<int>(w.step.failed, failed);
    for (int s = 0; s < slots; ++s)
      (*status)[converged[s]] = controls_[converged[s]].Conclude(
          failed[s] == 0 ? std::optional(radius[s]) : std::nullopt);
  }

  void Collect(const std::vector<int>& converged, const std::vector<EquilibriumStatus>& status,
               std::span<EquilibriumResult> results) const {
    const std::size_t dofs = cloth_.num_dofs();
    std::vector<double> here(count_ * dofs), best(here.size());
    CopyToHost<double>(here_.x, here);
    CopyToHost<double>(best_.x, best);
    std::vector<char> at_rest(count_);
    for (const int r : converged) at_rest[r] = 1;
    for (int r = 0; r < count_; ++r) {
      EquilibriumResult& result = results[r];
      result.status = status[r];
      result.x.resize(dofs);
      engine_.cloth_->ToMeshOrder((at_rest[r] ? here : best).data() + r * dofs, 1, 1,
                                  result.x.data());
      result.iterations = controls_[r].iterations();
      result.factorisations = controls_[r].factorisations();
      result.residual = (at_rest[r] ? measured_ : best_measured_)[r].residual;
      result.start_energy = start_[r].energy;
      result.steps = controls_[r].steps();
    }
  }

  DeviceEngine& engine_;
  const ClothView& cloth_;
  const EquilibriumOptions& options_;
  int count_;
  cudaStream_t stream_;
  DeviceMaterials materials_;
  Layout layout_{};
  Shapes here_{}, best_{};
  std::vector<double> weight_;
  std::vector<NewtonControl> controls_;
  std::vector<Measured> measured_, best_measured_, start_;
};

void DeviceEngine::Equilibria(std::span<const RolloutInput> batch,
                              const EquilibriumOptions& options,
                              std::span<EquilibriumResult> results) {
  Bind();
  const int most = SlotsThatFit(static_cast<int>(batch.size()), [&](Arena& arena, int slots) {
    BatchNewton::TakeAll(arena, *cloth_, slots);
  });
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    BatchNewton(*this, batch.subspan(first, count), options).Run(results.subspan(first, count));
  }
}

}  // namespace drape
