// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/engine/device_engine.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

struct DeviceEngine::TangentWorkspace {
  StepWorkspace step;
  DerivativeRecords derivatives;
  FactorRecords factors;
  double* blocks;   // [9·num_blocks] a slot
  double *dx, *dv;  // [3V, kPaddedEntries]
  double* vectors;  // [vector_size, kPaddedEntries]

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
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * kPaddedEntries);
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
  ForEachTangentChunk(batch.size(), [&](std::size_t first, std::size_t count) {
    const std::span<TangentResult> of_chunk = results.subspan(first, count);
    std::vector<RolloutResult*> ends;
    for (TangentResult& result : of_chunk) ends.push_back(&result.rollout);
    const TangentWorkspace w =
        TangentChunk(batch.subspan(first, count), weights.subspan(first, count), options, ends,
                     failed.subspan(first, count));
    DownloadTangents(w.dx, of_chunk, &TangentResult::dx);
    DownloadTangents(w.dv, of_chunk, &TangentResult::dv);
  });
}

void DeviceEngine::ReadoutTangents(std::span<const RolloutInput> batch,
                                   std::span<const MaterialField* const> weights,
                                   const RolloutOptions& options, const Readout& readout,
                                   std::span<ReadoutTangent> results, std::span<char> failed) {
  ForEachTangentChunk(batch.size(), [&](std::size_t first, std::size_t count) {
    const std::span<ReadoutTangent> of_chunk = results.subspan(first, count);
    std::vector<RolloutResult*> ends;
    for (ReadoutTangent& result : of_chunk) ends.push_back(&result.rollout);
    const std::span<char> flags = failed.subspan(first, count);
    const TangentWorkspace w = TangentChunk(batch.subspan(first, count),
                                            weights.subspan(first, count), options, ends, flags);
    std::vector<const Eigen::VectorXd*> shapes;
    std::vector<LinearReadout*> reads;
    for (std::size_t i = 0; i < count; ++i) {
      const bool ended = flags[i] == 0 && of_chunk[i].rollout.status == RolloutStatus::kOk;
      shapes.push_back(ended ? &of_chunk[i].rollout.end.x : nullptr);
      reads.push_back(&of_chunk[i].read);
    }
    ReadTangents({w.step.x, w.dx, shapes}, ReadoutFrom(readout, first), reads);
  });
}

void DeviceEngine::ForEachTangentChunk(std::size_t count, const ChunkWork& work) {
  Bind();
  const int most = SlotsThatFit(static_cast<int>(count), [&](Arena& arena, int slots) {
    TangentWorkspace::Take(arena, *cloth_, slots);
  });
  for (std::size_t first = 0; first < count; first += most)
    work(first, std::min<std::size_t>(most, count - first));
}

DeviceEngine::TangentWorkspace DeviceEngine::TangentChunk(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
    const RolloutOptions& options, std::span<RolloutResult* const> ends, std::span<char> failed) {
  const int slots = static_cast<int>(batch.size());
  const std::int64_t columns = std::int64_t{kPaddedEntries} * cloth_->view().num_dofs();
  TangentWorkspace w{};
  const auto take = [&](Arena& arena, int n) { w = TangentWorkspace::Take(arena, *cloth_, n); };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  std::vector<const MaterialField*> fields;
  for (const RolloutInput& input : batch) fields.push_back(input.material);
  const DeviceMaterials materials(fields), scales(weights);
  UploadStarts(batch, w.step.x, w.step.v);
  Clear(w.step.failed, slots * sizeof(int));
  Clear(w.dx, slots * columns * sizeof(double));
  Clear(w.dv, slots * columns * sizeof(double));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  const Graph step(*streams_, [&] {
    streams_->ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchTangentStep(w, SliceBatch(shapes, first, count, cloth_->view().num_dofs()),
                        scales.views() + first, first, options.h, stream);
    });
  });
  const int done = RunSteps(step, options.steps, options.cancel);
  CollectEnds(w.step, done, options.steps, ends, failed);
  return w;
}

void DeviceEngine::LaunchTangentStep(const TangentWorkspace& w, const ShapeBatch& group,
                                     const MaterialView* scales, std::int64_t first, double h,
                                     cudaStream_t stream) const {
  const ClothView& cloth = cloth_->view();
  const PlanView& plan = cloth_->multifrontal().view();
  const std::int64_t dofs = cloth.num_dofs(), columns = dofs * kPaddedEntries;
  const double* found = w.step.solution + first * dofs;
  double *dx = w.dx + first * columns, *dv = w.dv + first * columns;
  double* blocks = w.blocks + first * 9 * cloth.num_blocks;
  const DerivativeRecords derivatives = w.DerivativesFrom(cloth, first);
  const FactorRecords factors = w.FactorsFrom(cloth, first);
  LaunchSolveStep(w.step, group, static_cast<int>(first), h, stream);
  LaunchDerivativeRecords(cloth, group, cloth_->law(), found, h, derivatives, stream);
  LaunchFactorRecords(cloth, group, cloth_->law(), scales, found, h, factors, stream);
  LaunchGatherDerivative(cloth, derivatives, h, blocks, group.slots, stream);
  LaunchTangentRhs(cloth, group, factors, blocks, dx, dv, stream);
  cloth_->multifrontal().Solve(w.step.factor.From(first, plan.factor_size), dv, dv,
                               w.vectors + first * kPaddedEntries * plan.vector_size,
                               kPaddedEntries, group.slots, stream, {dx, h});
  LaunchAdvanceGroup(w.step, {nullptr, nullptr, 0, nullptr}, static_cast<int>(first), group.slots,
                     h, stream);
}

void DeviceEngine::DownloadTangents(const double* from, std::span<TangentResult> results,
                                    RowMatrix TangentResult::*part) const {
  const std::int64_t dofs = cloth_->view().num_dofs(), columns = dofs * kPaddedEntries;
  std::vector<double> host(results.size() * columns);
  CopyToHost<double>(from, host);
#pragma omp parallel for num_threads(threads_)
  for (std::size_t i = 0; i < results.size(); ++i) {
    RowMatrix& to = results[i].*part;
    to.resize(dofs, kMaterialEntries);
    cloth_->ToMeshOrder(host.data() + i * columns, kMaterialEntries, kPaddedEntries, to.data());
  }
}

}  // namespace drape
