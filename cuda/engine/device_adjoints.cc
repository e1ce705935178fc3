// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "cuda/engine/adjoint_workspace.h"

namespace drape {

namespace {

// Where the states of each slot lie: those of a history on the device, or uploaded from the host.
class HistoryTable {
 public:
  HistoryTable(const DeviceCloth& cloth, std::span<const Recording* const> recordings, int steps) {
    const int dofs = cloth.view().num_dofs();
    std::vector<HistorySlot> slots;
    for (const Recording* recording : recordings) {
      if (const auto* own = dynamic_cast<const DeviceRecording*>(recording->backend.get())) {
        const std::int64_t at = static_cast<std::int64_t>(own->slot) * dofs;
        slots.push_back({own->history->x.data() + at, own->history->v.data() + at,
                         static_cast<std::int64_t>(own->history->slots) * dofs});
      } else {
        slots.push_back(Upload(cloth, *recording, steps));
      }
    }
    slots_ = DeviceBuffer<HistorySlot>(slots);
  }
  const HistorySlot* slots() const { return slots_.data(); }

 private:
  HistorySlot Upload(const DeviceCloth& cloth, const Recording& recording, int steps) {
    const int dofs = cloth.view().num_dofs();
    std::vector<double> x(static_cast<std::size_t>(steps) * dofs), v(x.size());
    for (int k = 0; k < steps; ++k) {
      cloth.ToEliminationOrder(recording.x[k].data(), 1, 1, x.data() + std::size_t{1} * k * dofs);
      cloth.ToEliminationOrder(recording.v[k + 1].data(), 1, 1,
                               v.data() + std::size_t{1} * k * dofs);
    }
    uploaded_.emplace_back(x);
    uploaded_.emplace_back(v);
    return {uploaded_[uploaded_.size() - 2].data(), uploaded_.back().data(), dofs};
  }

  std::vector<DeviceBuffer<double>> uploaded_;
  DeviceBuffer<HistorySlot> slots_;
};

// The factors of the recordings' steps, when they are those of neighbouring slots of one history;
// base is null otherwise.
FactorPlace KeptFactors(std::span<const Recording* const> recordings, std::int64_t factor_size,
                        const int* step) {
  const auto* first = dynamic_cast<const DeviceRecording*>(recordings[0]->backend.get());
  if (first == nullptr || first->history->factor.size() == 0) return {nullptr};
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const auto* own = dynamic_cast<const DeviceRecording*>(recordings[i]->backend.get());
    if (own == nullptr || own->history != first->history ||
        own->slot != first->slot + static_cast<int>(i))
      return {nullptr};
  }
  double* base = const_cast<double*>(first->history->factor.data());
  return {base + first->slot * factor_size, step, first->history->slots * factor_size};
}

int CountSteps(const Recording& recording) {
  const auto* own = dynamic_cast<const DeviceRecording*>(recording.backend.get());
  return own != nullptr ? own->steps : static_cast<int>(recording.factor.size());
}

}  // namespace

void DeviceEngine::Adjoints(std::span<const RolloutInput> batch,
                            std::span<const Recording* const> recordings,
                            std::span<const RowMatrix* const> seeds, const RolloutOptions& options,
                            std::span<AdjointResult> results, std::span<char> failed) {
  Bind();
  const int m = PaddedColumns(static_cast<int>(seeds[0]->cols()));
  const auto take = [&](Arena& arena, int n) { AdjointWorkspace::Take(arena, *cloth_, n, m); };
  const std::size_t beside = GradientBytes(cloth_->view(), m) +
                             HistoryBytes(cloth_->view().num_dofs(), CountSteps(*recordings[0]));
  const int most = SlotsThatFit(static_cast<int>(batch.size()), take, beside);
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    AdjointChunk(batch.subspan(first, count), recordings.subspan(first, count),
                 seeds.subspan(first, count), options, results.subspan(first, count),
                 failed.subspan(first, count));
  }
}

// One step back of a batch.
struct DeviceEngine::AdjointStep {
  const AdjointWorkspace& w;
  const ShapeBatch& shapes;
  const HistorySlot* history;
  DeviceGradient& sums;
  double h;
  int columns;
  bool factors_kept;
};

DeviceEngine::AdjointRun DeviceEngine::RunAdjoint(std::span<const RolloutInput> batch,
                                                  std::span<const Recording* const> recordings,
                                                  int columns, const WriteSeeds& write_seeds,
                                                  const RolloutOptions& options) {
  const int slots = static_cast<int>(batch.size()), steps = CountSteps(*recordings[0]);
  const ClothView& cloth = cloth_->view();
  AdjointWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = AdjointWorkspace::Take(arena, *cloth_, n, columns);
  };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  std::vector<const MaterialField*> fields;
  for (const RolloutInput& input : batch) fields.push_back(input.material);
  const DeviceMaterials materials(fields);
  const HistoryTable history(*cloth_, recordings, steps);
  DeviceGradient sums(batch, cloth.num_faces, cloth.num_hinges, columns);
  write_seeds(w.adj_x);
  Clear(w.adj_v, sizeof(double) * slots * columns * cloth.num_dofs());
  Clear(w.step.failed, slots * sizeof(int));
  const std::vector<int> last_step{steps - 1};
  CopyToDevice<int>(last_step, w.step.step);
  const FactorPlace kept =
      KeptFactors(recordings, cloth_->multifrontal().view().factor_size, w.step.step);
  if (kept.base != nullptr) w.step.factor = kept;
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  const AdjointStep back{w,         shapes,  history.slots(),     sums,
                         options.h, columns, kept.base != nullptr};
  const Graph step(*streams_, [&] {
    streams_->ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchAdjointStep(back, first, count, stream);
    });
    LaunchCountStep(w.step.step, -1, streams_->main());
  });
  const int done = RunSteps(step, steps, options.cancel);
  streams_->Synchronize();
  std::vector<int> failed(slots);
  CopyToHost<int>(w.step.failed, failed);
  return {w, std::move(sums), std::move(failed), done};
}

void DeviceEngine::LaunchAdjointStep(const AdjointStep& back, int first, int count,
                                     cudaStream_t stream) const {
  const AdjointWorkspace& w = back.w;
  const ClothView& cloth = cloth_->view();
  const PlanView& plan = cloth_->multifrontal().view();
  const int m = back.columns;
  const std::int64_t dofs = cloth.num_dofs(), columns = dofs * m;
  const ShapeBatch group = SliceBatch(back.shapes, first, count, static_cast<int>(dofs));
  double *adj_x = w.adj_x + first * columns, *adj_v = w.adj_v + first * columns;
  double *lambda = w.lambda + first * columns, *end_v = w.step.v + first * dofs;
  LaunchLoadHistory(back.history + first, w.step.step, w.step.x + first * dofs, end_v,
                    static_cast<int>(dofs), count, stream);
  LaunchAdjointRhs(cloth, adj_x, adj_v, back.h, lambda, m, count, stream);
  // A single right-hand side rides along with a new factorisation.
  if (!back.factors_kept)
    LaunchFactorStep(w.step, group, first, back.h, m == 1 ? lambda : nullptr, stream);
  if (back.factors_kept || m > 1)
    cloth_->multifrontal().Solve(w.step.factor.From(first, plan.factor_size), lambda, lambda,
                                 w.vectors + 1LL * first * m * plan.vector_size, m, count, stream);
  if (m == 1) {
    const AdjointRecords records{w.single.faces + 1LL * first * cloth.num_faces,
                                 w.single.hinges + 1LL * first * cloth.num_hinges};
    LaunchAdjointRecords(cloth, group, cloth_->law(), end_v, back.h, lambda, records,
                         back.sums.From(first), stream);
    LaunchGatherAdjoint(cloth, group, records, back.h, lambda, adj_x, adj_v, stream);
    return;
  }
  double* blocks = w.blocks + first * 9LL * cloth.num_blocks;
  const DerivativeRecords derivatives{w.derivatives.faces + 1LL * first * cloth.num_faces,
                                      w.derivatives.hinges + 1LL * first * cloth.num_hinges};
  LaunchDerivativeRecords(cloth, group, cloth_->law(), end_v, back.h, derivatives, stream);
  LaunchGatherDerivative(cloth, derivatives, back.h, blocks, count, stream);
  LaunchAdjointPosition(cloth, group, blocks, lambda, adj_x, adj_v, m, stream);
  LaunchAdjointMaterial(cloth, group, cloth_->law(), end_v, back.h, lambda, back.sums.From(first),
                        m, stream);
}

void DeviceEngine::AdjointChunk(std::span<const RolloutInput> batch,
                                std::span<const Recording* const> recordings,
                                std::span<const RowMatrix* const> seeds,
                                const RolloutOptions& options, std::span<AdjointResult> results,
                                std::span<char> failed) {
  const int slots = static_cast<int>(batch.size()), seeded = static_cast<int>(seeds[0]->cols());
  const int m = PaddedColumns(seeded);
  const std::int64_t dofs = cloth_->view().num_dofs(), columns = dofs * m;
  std::vector<double> host(slots * columns);
  AdjointRun run = RunAdjoint(
      batch, recordings, m,
      [&](double* adj_x) {
        for (int i = 0; i < slots; ++i)
          cloth_->ToEliminationOrder(seeds[i]->data(), seeded, m, host.data() + i * columns);
        CopyToDevice<double>(host, adj_x);
      },
      options);
  for (int i = 0; i < slots; ++i) results[i].material = run.sums.Collect(batch[i], i, seeded);
  const auto collect = [&](const double* from, RowMatrix AdjointResult::*part) {
    CopyToHost<double>(from, host);
    for (int i = 0; i < slots; ++i) {
      RowMatrix& to = results[i].*part;
      to.resize(dofs, seeded);
      cloth_->ToMeshOrder(host.data() + i * columns, seeded, m, to.data());
    }
  };
  collect(run.workspace.adj_x, &AdjointResult::x0);
  collect(run.workspace.adj_v, &AdjointResult::v0);
  for (int i = 0; i < slots; ++i) {
    failed[i] = run.failed[i] != 0;
    if (run.done < CountSteps(*recordings[0])) results[i] = {RolloutStatus::kCancelled, {}, {}, {}};
  }
}

}  // namespace drape
