// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/engine/rollouts/rollout_engine.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {
namespace {

// Workspace of the adjoint pass through recorded rollouts by slot.
struct AdjointWorkspace {
  StepWorkspace step;     // x: of the present step; v: its end
  AdjointRecords single;  // for one column; for more:
  DerivativeRecords derivatives;
  double* blocks;                  // [9·num_blocks] a slot
  double *adj_x, *adj_v, *lambda;  // [3V, columns]
  double* vectors;                 // [vector_size, columns]

  static AdjointWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots, int columns) {
    const std::size_t n = slots;
    const ClothView& view = cloth.view();
    AdjointWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    if (columns == 1) {
      w.single = {arena.Take<DeformationGradient<double>>(n * view.num_faces),
                  arena.Take<BendAdjoint>(n * view.num_hinges)};
    } else {
      w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                       arena.Take<HingeDerivative>(n * view.num_hinges)};
      w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    }
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    w.adj_x = arena.Take<double>(n * view.num_dofs() * columns);
    w.adj_v = arena.Take<double>(n * view.num_dofs() * columns);
    w.lambda = arena.Take<double>(n * view.num_dofs() * columns);
    return w;
  }
};

// One step back of a batch.
struct AdjointStep {
  const AdjointWorkspace& w;
  const HistorySlot* history;
  DeviceGradient& sums;
  double h;
  int columns;
  bool factors_kept;
};

// Launches the step back of a group of slots, from `first` on.
void LaunchAdjointStep(const LaunchContext& on, const Multifrontal& multifrontal,
                       const AdjointStep& back, int first) {
  const AdjointWorkspace& w = back.w;
  const PlanView& plan = multifrontal.view();
  const int m = back.columns;
  const std::int64_t dofs = on.cloth.num_dofs(), columns = dofs * m;
  double *adj_x = w.adj_x + first * columns, *adj_v = w.adj_v + first * columns;
  double *lambda = w.lambda + first * columns, *end_v = w.step.v + first * dofs;
  LaunchLoadHistory(on, back.history + first, w.step.step, w.step.x + first * dofs, end_v);
  LaunchAdjointRhs(on, adj_x, adj_v, back.h, lambda, m);
  // A single right-hand side is solved for during a new factorisation.
  if (!back.factors_kept)
    LaunchFactorStep(on, multifrontal, w.step, first, back.h, m == 1 ? lambda : nullptr);
  if (back.factors_kept || m > 1)
    multifrontal.Solve(w.step.factor.From(first, plan.factor_size),
                       {lambda, lambda, w.vectors + 1LL * first * m * plan.vector_size, m},
                       on.batch.slots, on.stream);
  if (m == 1) {
    const AdjointRecords records{w.single.faces + 1LL * first * on.cloth.num_faces,
                                 w.single.hinges + 1LL * first * on.cloth.num_hinges};
    LaunchAdjointRecords(on, end_v, back.h, lambda, records, back.sums.From(first));
    LaunchGatherAdjoint(on, records, end_v, back.h, lambda, adj_x, adj_v);
    return;
  }
  double* blocks = w.blocks + first * 9LL * on.cloth.num_blocks;
  const DerivativeRecords derivatives{w.derivatives.faces + 1LL * first * on.cloth.num_faces,
                                      w.derivatives.hinges + 1LL * first * on.cloth.num_hinges};
  LaunchDerivativeRecords(on, end_v, back.h, derivatives);
  LaunchGatherDerivative(on, derivatives, end_v, back.h, blocks);
  LaunchAdjointPosition(on, blocks, lambda, adj_x, adj_v, m);
  LaunchAdjointMaterial(on, end_v, back.h, lambda, back.sums.From(first), m);
}

}  // namespace

void RolloutEngine::Adjoints(std::span<const RolloutInput> batch,
                             std::span<const Recording* const> recordings,
                             std::span<const RowMatrix* const> dL_dx, const RolloutOptions& options,
                             std::span<AdjointResult> results, std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  const int used = static_cast<int>(dL_dx[0]->cols()), m = PaddedColumns(used);
  const int steps = CountSteps(*recordings[0]);
  const std::int64_t dofs = cloth.view().num_dofs(), columns = dofs * m;
  const auto take = [&](Arena& arena, int n) { AdjointWorkspace::Take(arena, cloth, n, m); };
  const std::size_t bytes = GradientBytes(cloth.view(), m) + HistoryBytes(cloth, steps);
  resources_.ForEachChunk(batch.size(), take, bytes, [&](std::size_t first, std::size_t count) {
    std::vector<double> host(count * columns);
    for (std::size_t i = 0; i < count; ++i)
      cloth.ToEliminationOrder(dL_dx[first + i]->data(), used, m, host.data() + i * columns);
    AdjointRun run =
        RunAdjoint(batch.subspan(first, count), recordings.subspan(first, count), m, host, options);
    const auto collect = [&](const double* from, RowMatrix AdjointResult::*part) {
      CopyToHost<double>(from, host);
      for (std::size_t i = 0; i < count; ++i) {
        RowMatrix& to = results[first + i].*part;
        to.resize(dofs, used);
        cloth.ToMeshOrder(host.data() + i * columns, used, m, to.data());
      }
    };
    collect(run.adj_x, &AdjointResult::x0);
    collect(run.adj_v, &AdjointResult::v0);
    for (std::size_t i = 0; i < count; ++i) {
      AdjointResult& result = results[first + i];
      failed[first + i] = run.failed[i] != 0;
      result.material = run.sums.Collect(batch[first + i], static_cast<int>(i), used);
      if (run.steps < steps) result = {RolloutStatus::kCancelled, {}, {}, {}};
    }
  });
}

AdjointRun RolloutEngine::RunAdjoint(std::span<const RolloutInput> batch,
                                     std::span<const Recording* const> recordings, int columns,
                                     const std::vector<double>& dL_dx,
                                     const RolloutOptions& options) {
  const DeviceCloth& cloth = resources_.cloth();
  const int slots = static_cast<int>(batch.size()), steps = CountSteps(*recordings[0]);
  const int dofs = cloth.view().num_dofs();
  AdjointWorkspace w{};
  resources_.Allocate(
      slots, [&](Arena& arena, int n) { w = AdjointWorkspace::Take(arena, cloth, n, columns); });
  const DeviceMaterials materials(CollectMaterials(batch));
  const HistoryTable history(cloth, recordings, steps);
  DeviceGradient sums(batch, cloth.view().num_faces, cloth.view().num_hinges, columns);
  CopyToDevice<double>(dL_dx, w.adj_x);
  resources_.Clear(w.adj_v, sizeof(double) * slots * columns * dofs);
  resources_.Clear(w.step.failed, slots * sizeof(int));
  const std::vector<int> last_step{steps - 1};
  CopyToDevice<int>(last_step, w.step.step);
  const FactorPlace kept =
      FindKeptFactors(recordings, cloth.multifrontal().view().factor_size, w.step.step);
  if (kept.base != nullptr) w.step.factor = kept;
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  const AdjointStep back{w, history.slots(), sums, options.h, columns, kept.base != nullptr};
  const Streams& streams = resources_.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchAdjointStep(resources_.On(SliceBatch(shapes, first, count, dofs), stream),
                        cloth.multifrontal(), back, first);
    });
    LaunchCountStep(w.step.step, -1, streams.main());
  });
  const int done = resources_.RunSteps(step, steps, options.cancel);
  streams.Synchronize();
  std::vector<int> failed(slots);
  CopyToHost<int>(w.step.failed, failed);
  return {w.adj_x, w.adj_v, std::move(sums), std::move(failed), done};
}

}  // namespace drape
