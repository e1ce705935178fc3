// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/equilibrium_engine.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cuda/engine/device_resources.h"
#include "cuda/kernels/element_kernels.h"
#include "cuda/kernels/statics/statics_kernels.h"
#include "physics/linalg/linear_solver.h"
#include "physics/simulation/statics/statics.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {
namespace {

// Workspace of the implicit derivatives by slot; step.x: the shapes, step.v: zeros.
struct ImplicitWorkspace {
  StepWorkspace step;
  DerivativeRecords derivatives;
  FactorRecords factors;                         // of the tangents only
  double* mu;                                    // [1]
  double* blocks;                                // −K, [9·num_blocks]
  double *rhs, *x, *before, *residual, *solved;  // [3V, columns]
  double* vectors;                               // [vector_size, columns]
  double *dots, *weights;                        // [columns]

  static ImplicitWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots, int columns,
                                bool tangents) {
    const std::size_t n = slots, numbers = n * cloth.view().num_dofs() * columns;
    const ClothView& view = cloth.view();
    ImplicitWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                     arena.Take<HingeDerivative>(n * view.num_hinges)};
    if (tangents)
      w.factors = {arena.Take<FaceFactors>(n * view.num_faces),
                   arena.Take<HingeFactors>(n * view.num_hinges)};
    w.mu = arena.Take<double>(n);
    w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    for (double** part : {&w.rhs, &w.x, &w.before, &w.residual, &w.solved})
      *part = arena.Take<double>(numbers);
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    w.dots = arena.Take<double>(n * columns);
    w.weights = arena.Take<double>(n * columns);
    return w;
  }
};

// The recurrences of a batch, one a slot: numbers of their active columns from and to [slots,
// columns].
class Recurrences {
 public:
  Recurrences(const std::vector<double>& squares, int slots, int columns, int used)
      : columns_(columns) {
    for (int s = 0; s < slots; ++s) {
      std::vector<double> norms(used);
      for (int j = 0; j < used; ++j) norms[j] = std::sqrt(squares[s * columns + j]);
      each_.emplace_back(norms);
    }
  }
  bool HasActive() const {
    return std::any_of(each_.begin(), each_.end(),
                       [](const CgwRecurrence& r) { return r.status() == CgwStatus::kGoOn; });
  }
  bool IsSolved(int slot) const { return each_[slot].status() == CgwStatus::kSolved; }

  // ω; −1 for columns that are not active.
  std::vector<double> Weights(const std::vector<double>& dots) {
    std::vector<double> weights(dots.size(), -1.0);
    ForEachActive([&](CgwRecurrence& r, int first) {
      const auto of_active = r.Weights(Active(r, dots, first));
      for (std::size_t k = 0; k < of_active.size(); ++k)
        weights[first + r.active()[k]] = of_active[k];
    });
    return weights;
  }
  void Judge(const std::vector<double>& squares) {
    ForEachActive([&](CgwRecurrence& r, int first) {
      std::vector<double> norms = Active(r, squares, first);
      for (double& norm : norms) norm = std::sqrt(norm);
      r.Judge(norms);
    });
  }

 private:
  template <class Work>
  void ForEachActive(const Work& work) {
    for (std::size_t s = 0; s < each_.size(); ++s)
      if (each_[s].status() == CgwStatus::kGoOn) work(each_[s], static_cast<int>(s) * columns_);
  }
  static std::vector<double> Active(const CgwRecurrence& r, const std::vector<double>& all,
                                    int first) {
    std::vector<double> active;
    for (const int j : r.active()) active.push_back(all[first + j]);
    return active;
  }

  int columns_;
  std::vector<CgwRecurrence> each_;
};

// Factors Ks of the batch's shapes, without shift; workspace.step.failed says where it could not.
void FactorStiffness(const DeviceResources& resources, const ImplicitWorkspace& w,
                     const ShapeBatch& batch) {
  const Multifrontal& multifrontal = resources.cloth().multifrontal();
  const LaunchContext on = resources.On(batch);
  resources.Clear(w.step.failed, batch.slots * sizeof(int));
  resources.Clear(w.step.v, sizeof(double) * batch.slots * on.cloth.num_dofs());
  resources.Clear(w.mu, sizeof(double) * batch.slots);
  LaunchDerivativeRecords(on, w.step.v, 1.0, w.derivatives);
  LaunchGatherDerivative(on, w.derivatives, w.step.v, 1.0, w.blocks);
  LaunchGatherStiffness(on, w.derivatives, {nullptr, nullptr, w.mu, 0.0}, w.step.matrix);
  multifrontal.FactorAndSolve(w.step.FactorFrom(multifrontal.view(), 0), nullptr, nullptr,
                              batch.slots, batch.slots, on.stream);
}

// Solves K·X = B or Kᵀ·X = B for workspace.rhs, where its first `used` columns count; true where
// each of them is solved. The workspace has PaddedColumns(used).
std::vector<char> SolveStiffness(const DeviceResources& resources, const ImplicitWorkspace& w,
                                 const ShapeBatch& batch, bool transposed, int used) {
  const Multifrontal& multifrontal = resources.cloth().multifrontal();
  const LaunchContext on = resources.On(batch);
  const int slots = batch.slots, columns = PaddedColumns(used);
  const std::int64_t count = static_cast<std::int64_t>(slots) * on.cloth.num_dofs() * columns;
  std::vector<double> numbers(slots * columns);
  const auto dots = [&](const double* a, const double* b) {
    LaunchColumnDots(on, a, b, w.dots, columns);
    resources.streams().Synchronize();
    CopyToHost<double>(w.dots, numbers);
  };
  dots(w.rhs, w.rhs);
  Recurrences recurrences(numbers, slots, columns, used);
  resources.Clear(w.x, count * sizeof(double));
  resources.Clear(w.before, count * sizeof(double));
  LaunchCopy(w.rhs, w.residual, count, on.stream);
  while (recurrences.HasActive()) {
    multifrontal.Solve(w.step.factor, {w.residual, w.solved, w.vectors, columns}, slots, on.stream);
    dots(w.residual, w.solved);
    CopyToDevice<double>(recurrences.Weights(numbers), w.weights);
    LaunchCgwAdvance(on, w.weights, w.solved, w.before, w.x, columns);
    LaunchCopy(w.rhs, w.residual, count, on.stream);
    LaunchMultiply(on, w.blocks, transposed, w.x, w.residual, columns);
    dots(w.residual, w.residual);
    recurrences.Judge(numbers);
  }
  const std::vector<int> failed = Download(w.step.failed, slots);
  std::vector<char> solved(slots);
  for (int s = 0; s < slots; ++s) solved[s] = failed[s] == 0 && recurrences.IsSolved(s);
  return solved;
}

// Memory of Newton's method: `work` has an item a slot, all else an item a rollout.
struct NewtonWorkspace {
  ImplicitWorkspace work;
  Shapes here, best;
  StretchStress<double>* geometric;
  double *dx, *scale, *move, *sums;
  int* rollout;
  ShapeAction* action;

  void Take(Arena& arena, const DeviceCloth& cloth, int n) {
    const std::size_t dofs = std::size_t{1} * n * cloth.view().num_dofs();
    const std::size_t faces = std::size_t{1} * n * cloth.view().num_faces;
    work = ImplicitWorkspace::Take(arena, cloth, n, 1, false);
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

// Newton's method for a batch of drapes at rest that fits into the device's memory. The decisions
// are those of physics/simulation/statics/statics.h, one NewtonControl per rollout; the shapes stay
// on the device.
class BatchNewton {
 public:
  BatchNewton(DeviceResources& resources, std::span<const RolloutInput> batch,
              const EquilibriumOptions& options)
      : resources_(resources),
        cloth_(resources.cloth()),
        options_(options),
        count_(static_cast<int>(batch.size())),
        dofs_(resources.view().num_dofs()),
        materials_(CollectMaterials(batch)) {
    resources_.Allocate(count_, [&](Arena& arena, int n) { workspace_.Take(arena, cloth_, n); });
    here_ = workspace_.here;
    best_ = workspace_.best;
    resources_.UploadStarts(batch, here_.x, nullptr);
    std::vector<int> all(count_);
    for (int r = 0; r < count_; ++r) all[r] = r;
    for (const RolloutInput& input : batch)
      weight_.push_back(CharacteristicForce(cloth_.model(), *input.material));
    LaunchPushOut(On(all), here_.x);
    const std::vector<Measured> start = Measure(all);
    for (int r = 0; r < count_; ++r)
      controls_.emplace_back(options, start[r].residual, start[r].energy);
    measured_ = best_measured_ = start_ = start;
    Act(all, std::vector<ShapeAction>(count_, ShapeAction::kKeep));
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
  // Slots of these rollouts at their present shapes.
  LaunchContext On(const std::vector<int>& rollouts) {
    CopyToDevice<int>(rollouts, workspace_.rollout);
    const int slots = static_cast<int>(rollouts.size());
    return resources_.On({slots, slots, workspace_.rollout, materials_.views(), here_.x});
  }

  // Forces, stresses, ‖f‖ / weight and energy of the present shapes, in the order of `rollouts`.
  std::vector<Measured> Measure(const std::vector<int>& rollouts) {
    const LaunchContext on = On(rollouts);
    const StepRecords& records = workspace_.work.step.records;
    LaunchElementRecords(on, records);
    LaunchGatherForce(on, records, here_.force);
    LaunchMeasure(on, records, here_, workspace_.sums);
    resources_.streams().Synchronize();
    const std::vector<double> sums = Download(workspace_.sums, 2 * rollouts.size());
    std::vector<Measured> measured;
    for (std::size_t s = 0; s < rollouts.size(); ++s)
      measured.push_back({std::sqrt(sums[2 * s]) / weight_[rollouts[s]], sums[2 * s + 1]});
    return measured;
  }

  void Step(const std::vector<int>& active) {
    const std::vector<int> stepping = FindSteps(active);
    if (stepping.empty()) return;
    const LaunchContext on = On(stepping);
    double* dx = workspace_.work.step.solution;
    LaunchGatherRows(on, workspace_.dx, dx);
    LaunchLargestMove(on, dx, workspace_.move);
    resources_.streams().Synchronize();
    std::vector<double> scale = Download(workspace_.move, on.batch.slots);
    for (int s = 0; s < on.batch.slots; ++s) scale[s] = controls_[stepping[s]].Scale(scale[s]);
    CopyToDevice<double>(scale, workspace_.scale);
    LaunchShortenMoves(on, {workspace_.scale, 0.0}, dx, nullptr);
    LaunchMoveShapes(on, dx, workspace_.scale, workspace_.geometric, here_.x);
    const std::vector<Measured> measured = Measure(stepping);
    std::vector<ShapeAction> actions;
    for (int s = 0; s < on.batch.slots; ++s) actions.push_back(Judge(stepping[s], measured[s]));
    Act(stepping, actions);
  }

  // Newton steps of the rollouts in workspace_.dx; those whose stiffness no shift made positive
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
    ImplicitWorkspace& w = workspace_.work;
    const LaunchContext on = On(rollouts);
    const Multifrontal& multifrontal = cloth_.multifrontal();
    const int slots = on.batch.slots;
    CopyToDevice<double>(mu, w.mu);
    resources_.Clear(w.step.failed, slots * sizeof(int));
    resources_.Clear(w.step.v, sizeof(double) * slots * dofs_);
    LaunchDerivativeRecords(on, w.step.v, 1.0, w.derivatives);
    LaunchGatherStiffness(on, w.derivatives,
                          {workspace_.geometric, here_.stress, w.mu, options_.shift.length},
                          w.step.matrix);
    LaunchGatherRows(on, here_.force, w.step.rhs);
    multifrontal.FactorAndSolve(w.step.FactorFrom(multifrontal.view(), 0), w.step.rhs,
                                w.step.solution, slots, slots, on.stream);
    LaunchScatterRows(on, w.step.solution, workspace_.dx);
    resources_.streams().Synchronize();
    return Download(w.step.failed, slots);
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
    const LaunchContext on = On(rollouts);
    CopyToDevice<ShapeAction>(actions, workspace_.action);
    LaunchShapeAction(on, workspace_.action, here_, best_, workspace_.geometric);
    resources_.streams().Synchronize();
  }

  // The status of the rollouts at rest: Stiffness::Factor and Asymmetry.
  void Conclude(const std::vector<int>& converged, std::vector<EquilibriumStatus>* status) {
    if (converged.empty()) return;
    const ImplicitWorkspace& w = workspace_.work;
    const LaunchContext on = On(converged);
    const int slots = on.batch.slots;
    FactorStiffness(resources_, w, on.batch);
    std::vector<double> directions(std::size_t{1} * slots * dofs_);
    const RowMatrix start = AsymmetryStart(dofs_);
    for (int s = 0; s < slots; ++s)
      cloth_.ToEliminationOrder(start.data(), 1, 1, directions.data() + std::size_t{1} * s * dofs_);
    CopyToDevice<double>(directions, w.x);
    resources_.Clear(w.rhs, sizeof(double) * slots * dofs_);
    for (int round = 0; round < kAsymmetryRounds; ++round) {
      LaunchMultiply(on, w.blocks, false, w.x, w.rhs, 1);
      cloth_.multifrontal().Solve(w.step.factor, {w.rhs, w.rhs, w.vectors, 1}, slots, on.stream);
      LaunchPowerStep(on, w.rhs, w.x, w.dots);
    }
    resources_.streams().Synchronize();
    const std::vector<double> radius = Download(w.dots, slots);
    const std::vector<int> failed = Download(w.step.failed, slots);
    for (int s = 0; s < slots; ++s)
      (*status)[converged[s]] = controls_[converged[s]].Conclude(
          failed[s] == 0 ? std::optional(radius[s]) : std::nullopt);
  }

  void Collect(const std::vector<int>& converged, const std::vector<EquilibriumStatus>& status,
               std::span<EquilibriumResult> results) const {
    const std::size_t dofs = dofs_;
    const std::vector<double> here = Download(here_.x, count_ * dofs);
    const std::vector<double> best = Download(best_.x, here.size());
    std::vector<char> at_rest(count_);
    for (const int r : converged) at_rest[r] = 1;
    for (int r = 0; r < count_; ++r) {
      EquilibriumResult& result = results[r];
      result.status = status[r];
      result.x.resize(dofs);
      cloth_.ToMeshOrder((at_rest[r] ? here : best).data() + r * dofs, 1, 1, result.x.data());
      result.iterations = controls_[r].iterations();
      result.factorisations = controls_[r].factorisations();
      result.residual = (at_rest[r] ? measured_ : best_measured_)[r].residual;
      result.start_energy = start_[r].energy;
      result.steps = controls_[r].steps();
    }
  }

  DeviceResources& resources_;
  const DeviceCloth& cloth_;
  const EquilibriumOptions& options_;
  int count_, dofs_;
  DeviceMaterials materials_;
  NewtonWorkspace workspace_{};
  Shapes here_{}, best_{};
  std::vector<double> weight_;
  std::vector<NewtonControl> controls_;
  std::vector<Measured> measured_, best_measured_, start_;
};

// Right-hand sides of a chunk: ∂f/∂p of the shapes.
using FillRhs = std::function<void(const LaunchContext& on, const ImplicitWorkspace& workspace)>;

// Solves for chunks of the batch, `columns` right-hand sides each, of which a result keeps the
// first used(input); it is empty where it is not solved.
template <class Result>
void SolveChunks(DeviceResources& resources, std::span<const RolloutInput> batch,
                 std::span<const MaterialField* const> weights,
                 const std::function<int(const RolloutInput&)>& used, int columns,
                 const FillRhs& fill_rhs, std::span<Result> results) {
  const DeviceCloth& cloth = resources.cloth();
  const std::size_t dofs = cloth.view().num_dofs(), numbers = dofs * columns;
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, cloth, n, columns, true);
  };
  resources.ForEachChunk(batch.size(), take, 0, [&](std::size_t first, std::size_t count) {
    const int slots = static_cast<int>(count);
    const auto chunk = batch.subspan(first, count);
    resources.Allocate(slots, take);
    const DeviceMaterials materials(CollectMaterials(chunk)), scales(weights.subspan(first, count));
    resources.UploadStarts(chunk, w.step.x, nullptr);
    const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
    const LaunchContext on = resources.On(shapes);
    FactorStiffness(resources, w, shapes);
    LaunchFactorRecords(on, scales.views(), w.step.v, 1.0, w.factors);
    fill_rhs(on, w);
    const std::vector<char> solved = SolveStiffness(resources, w, shapes, false, columns);
    const std::vector<double> host = Download(w.x, count * numbers);
#pragma omp parallel for num_threads(resources.threads())
    for (std::size_t i = 0; i < count; ++i) {
      Result& result = results[first + i];
      result = Result();
      if (!solved[i]) continue;
      result.resize(dofs, used(chunk[i]));
      cloth.ToMeshOrder(host.data() + i * numbers, static_cast<int>(result.cols()), columns,
                        result.data());
    }
  });
}

}  // namespace

void EquilibriumEngine::Equilibria(std::span<const RolloutInput> batch,
                                   const EquilibriumOptions& options,
                                   std::span<EquilibriumResult> results) {
  const auto take = [&](Arena& arena, int slots) {
    NewtonWorkspace().Take(arena, resources_.cloth(), slots);
  };
  resources_.ForEachChunk(batch.size(), take, 0, [&](std::size_t first, std::size_t count) {
    BatchNewton(resources_, batch.subspan(first, count), options)
        .Run(results.subspan(first, count));
  });
}

void EquilibriumEngine::Tangents(std::span<const RolloutInput> batch,
                                 std::span<const MaterialField* const> weights,
                                 std::span<RowMatrix> results) {
  // The column of the density is in the padding; the other numbers of DynamicsEntry are of motions.
  static_assert(kByDensity == 0 && kPaddedEntries == kMaterialEntries + 1);
  const auto wants_dynamics = [](const RolloutInput& input) {
    return input.tangent != nullptr && input.tangent->dynamics;
  };
  SolveChunks(
      resources_, batch, weights,
      [&](const RolloutInput& input) { return kMaterialEntries + (wants_dynamics(input) ? 1 : 0); },
      kPaddedEntries,
      [](const LaunchContext& on, const ImplicitWorkspace& w) {
        LaunchTangentRhs(on, w.factors, nullptr, nullptr, w.rhs, kPaddedEntries);
        LaunchDynamicsColumns(on, {w.step.v, w.step.v, 1.0},
                              {.matrix = w.rhs,
                               .columns = kPaddedEntries,
                               .first = kMaterialEntries,
                               .count = kByDensity + 1});
      },
      results);
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (results[i].size() > 0 && wants_dynamics(batch[i]))
      results[i].conservativeResizeLike(
          RowMatrix::Zero(results[i].rows(), kMaterialEntries + kDynamicsEntries));
}

void EquilibriumEngine::Jvp(std::span<const RolloutInput> batch,
                            std::span<const MaterialField* const> changes,
                            std::span<Eigen::VectorXd> results) {
  SolveChunks(
      resources_, batch, changes, [](const RolloutInput&) { return 1; }, 1,
      [](const LaunchContext& on, const ImplicitWorkspace& w) {
        LaunchDirectionRhs(on, w.factors, w.rhs);
      },
      results);
}

void EquilibriumEngine::Adjoints(std::span<const RolloutInput> batch,
                                 std::span<const RowMatrix* const> dL_dx,
                                 std::span<std::optional<MaterialGradient>> results) {
  const DeviceCloth& cloth = resources_.cloth();
  const ClothView& view = cloth.view();
  const int used = static_cast<int>(dL_dx[0]->cols()), m = PaddedColumns(used);
  const std::size_t columns = std::size_t{1} * m * view.num_dofs();
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, cloth, n, m, false);
  };
  const auto solve = [&](std::size_t first, std::size_t count) {
    const int slots = static_cast<int>(count);
    const auto chunk = batch.subspan(first, count);
    resources_.Allocate(slots, take);
    std::vector<double> host(count * columns);
    for (std::size_t i = 0; i < count; ++i)
      cloth.ToEliminationOrder(dL_dx[first + i]->data(), used, m, host.data() + i * columns);
    const DeviceMaterials materials(CollectMaterials(chunk));
    DeviceGradient gradient(chunk, view.num_faces, view.num_hinges, m);
    resources_.UploadStarts(chunk, w.step.x, nullptr);
    CopyToDevice<double>(host, w.rhs);
    const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
    FactorStiffness(resources_, w, shapes);
    const std::vector<char> solved = SolveStiffness(resources_, w, shapes, true, used);
    LaunchAdjointMaterial(resources_.On(shapes), w.step.v, 1.0, w.x, gradient.From(0), m);
    resources_.streams().Synchronize();
    for (int i = 0; i < slots; ++i)
      results[first + i] =
          solved[i] ? std::optional(gradient.Collect(chunk[i], i, used)) : std::nullopt;
  };
  resources_.ForEachChunk(batch.size(), take, GradientBytes(view, m), solve);
}

}  // namespace drape
