// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/device_engine.h"
#include "cuda/sensitivity_kernels.h"

namespace drape {

struct DeviceEngine::TangentWorkspace {
  StepWorkspace step;
  DerivativeRecords derivatives;
  FactorRecords factors;
  double* blocks;     // [9·num_blocks] a slot
  double *dx, *dv;    // [3V, kPaddedEntries]
  double* vectors;    // [vector_size, kPaddedEntries]

  static TangentWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots) {
    const std::size_t n = slots;
    const ClothView& view = cloth.view();
    TangentWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                     arena.Take<HingeDerivative>(n * view.num_hinges)};
    w.factors = {arena.Take<FaceFactors>(n * view.num_faces),
                 arena.Take<HingeFactors>(n * view.num_hinges)};
    w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    w.dx = arena.Take<double>(n * view.num_dofs() * kPaddedEntries);
    w.dv = arena.Take<double>(n * view.num_dofs() * kPaddedEntries);
    w.vectors =
        arena.Take<double>(n * cloth.multifrontal().view().vector_size * kPaddedEntries);
    return w;
  }

  // Pieces of the slots from `first` on.
  DerivativeRecords DerivativesFrom(const ClothView& cloth, std::int64_t first) const {
    return {derivatives.faces + first * cloth.num_faces,
            derivatives.hinges + first * cloth.num_hinges};
  }
  FactorRecords FactorsFrom(const ClothView& cloth, std::int64_t first) const {
    return {factors.faces + first * cloth.num_faces, factors.hinges + first * cloth.num_hinges};
  }
};

void DeviceEngine::Tangents(std::span<const RolloutInput> batch,
                            std::span<const MaterialField* const> weights,
                            const RolloutOptions& options, std::span<TangentResult> results,
                            std::span<char> failed) {
  Bind();
  const auto take = [&](Arena& arena, int slots) { TangentWorkspace::Take(arena, *cloth_, slots); };
  const int most = SlotsThatFit(static_cast<int>(batch.size()), take);
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    TangentChunk(batch.subspan(first, count), weights.subspan(first, count), options,
                 results.subspan(first, count), failed.subspan(first, count));
  }
}

void DeviceEngine::TangentChunk(std::span<const RolloutInput> batch,
                                std::span<const MaterialField* const> weights,
                                const RolloutOptions& options, std::span<TangentResult> results,
                                std::span<char> failed) {
  const int slots = static_cast<int>(batch.size());
  const ClothView& cloth = cloth_->view();
  const PlanView& plan = cloth_->multifrontal().view();
  const std::int64_t dofs = cloth.num_dofs(), columns = dofs * kPaddedEntries;
  TangentWorkspace w{};
  const auto take = [&](Arena& arena, int n) { w = TangentWorkspace::Take(arena, *cloth_, n); };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  std::vector<const MaterialField*> fields;
  std::vector<RolloutResult*> ends;
  for (int i = 0; i < slots; ++i) {
    fields.push_back(batch[i].material);
    ends.push_back(&results[i].rollout);
  }
  const DeviceMaterials materials(fields), scales(weights);
  UploadStarts(batch, w.step.x, w.step.v);
  Clear(w.step.failed, slots * sizeof(int));
  Clear(w.dx, slots * columns * sizeof(double));
  Clear(w.dv, slots * columns * sizeof(double));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  const HistoryView none{nullptr, nullptr, 0, nullptr};
  const double h = options.h;
  const Graph step(*streams_, [&] {
    streams_->ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      const ShapeBatch group = GroupOf(shapes, first, count, static_cast<int>(dofs));
      const double* found = w.step.solution + first * dofs;
      double *dx = w.dx + first * columns, *dv = w.dv + first * columns;
      double* blocks = w.blocks + first * 9LL * cloth.num_blocks;
      LaunchSolveStep(w.step, group, first, h, stream);
      const DerivativeRecords derivatives = w.DerivativesFrom(cloth, first);
      const FactorRecords factors = w.FactorsFrom(cloth, first);
      LaunchDerivativeRecords(cloth, group, cloth_->law(), found, h, derivatives, stream);
      LaunchFactorRecords(cloth, group, cloth_->law(), scales.views() + first, found, h, factors,
                          stream);
      LaunchGatherDerivative(cloth, derivatives, h, blocks, count, stream);
      LaunchTangentRhs(cloth, group, factors, blocks, dx, dv, stream);
      cloth_->multifrontal().Solve(w.step.factor + first * plan.factor_size, dv, dv,
                                   w.vectors + first * kPaddedEntries * 1LL * plan.vector_size,
                                   kPaddedEntries, count, stream, {dx, h});
      LaunchAdvanceGroup(w.step, none, first, count, h, stream);
    });
  });
  const int done = RunSteps(step, options.steps, options.cancel);
  CollectEnds(w.step, done, options.steps, ends, failed);
  std::vector<double> host(slots * columns);
  const auto collect = [&](const double* from, RowMatrix TangentResult::* part) {
    CopyToHost<double>(from, host);
#pragma omp parallel for
    for (int i = 0; i < slots; ++i) {
      RowMatrix& to = results[i].*part;
      to.resize(dofs, kMaterialEntries);
      cloth_->ToMeshOrder(host.data() + i * columns, kMaterialEntries, kPaddedEntries, to.data());
    }
  };
  collect(w.dx, &TangentResult::dx);
  collect(w.dv, &TangentResult::dv);
}

}  // namespace drape
