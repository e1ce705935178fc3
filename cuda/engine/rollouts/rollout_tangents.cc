// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/engine/rollouts/rollout_engine.h"
#include "cuda/kernels/contact_kernels.h"

namespace drape {
namespace {

struct TangentWorkspace {
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

// A step of a group of slots, from `first` on, and of its derivatives.
void LaunchTangentStep(const LaunchContext& on, const Multifrontal& multifrontal,
                       const TangentWorkspace& w, const MaterialView* scales, std::int64_t first,
                       double h) {
  const PlanView& plan = multifrontal.view();
  const std::int64_t dofs = on.cloth.num_dofs(), columns = dofs * kPaddedEntries;
  const double* found = w.step.solution + first * dofs;
  double *dx = w.dx + first * columns, *dv = w.dv + first * columns;
  double* blocks = w.blocks + first * 9 * on.cloth.num_blocks;
  const DerivativeRecords derivatives = w.DerivativesFrom(on.cloth, first);
  const FactorRecords factors = w.FactorsFrom(on.cloth, first);
  LaunchSolveStep(on, multifrontal, w.step, static_cast<int>(first), h);
  LaunchDerivativeRecords(on, found, h, derivatives);
  LaunchFactorRecords(on, scales, found, h, factors);
  LaunchGatherDerivative(on, derivatives, found, h, blocks);
  LaunchTangentRhs(on, factors, blocks, dx, dv);
  multifrontal.Solve(
      w.step.factor.From(first, plan.factor_size),
      {dv, dv, w.vectors + first * kPaddedEntries * plan.vector_size, kPaddedEntries},
      on.batch.slots, on.stream, {dx, h});
  LaunchAdvanceGroup(on, w.step, static_cast<int>(first), h, BlockedMove::kFails,
                     {nullptr, nullptr, 0, nullptr});
}

// The steps that were done.
int RunTangents(DeviceResources& resources, const TangentWorkspace& w,
                std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
                const RolloutOptions& options) {
  const DeviceCloth& cloth = resources.cloth();
  const int slots = static_cast<int>(batch.size()), dofs = cloth.view().num_dofs();
  const std::size_t columns = std::size_t{kPaddedEntries} * dofs;
  const DeviceMaterials materials(CollectMaterials(batch)), scales(weights);
  resources.UploadStarts(batch, w.step.x, w.step.v);
  resources.Clear(w.step.failed, slots * sizeof(int));
  resources.Clear(w.dx, slots * columns * sizeof(double));
  resources.Clear(w.dv, slots * columns * sizeof(double));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  LaunchPushOut(resources.On(shapes), w.step.x);
  const Streams& streams = resources.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchTangentStep(resources.On(SliceBatch(shapes, first, count, dofs), stream),
                        cloth.multifrontal(), w, scales.views() + first, first, options.h);
    });
  });
  const int done = resources.RunSteps(step, options.steps, options.cancel);
  streams.Synchronize();
  return done;
}

}  // namespace

void RolloutEngine::Tangents(std::span<const RolloutInput> batch,
                             std::span<const MaterialField* const> weights,
                             const RolloutOptions& options, std::span<TangentResult> results,
                             std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  std::vector<RolloutResult*> ends;
  for (TangentResult& result : results) ends.push_back(&result.rollout);
  TangentWorkspace w{};
  const auto take = [&](Arena& arena, int n) { w = TangentWorkspace::Take(arena, cloth, n); };
  resources_.ForEachChunk(batch.size(), take, 0, [&](std::size_t first, std::size_t count) {
    resources_.Allocate(static_cast<int>(count), take);
    const int done = RunTangents(resources_, w, batch.subspan(first, count),
                                 weights.subspan(first, count), options);
    CollectEnds(w.step, done, options.steps, std::span(ends).subspan(first, count),
                failed.subspan(first, count));
    const auto chunk = results.subspan(first, count);
    DownloadTangents(w.dx, chunk, &TangentResult::dx);
    DownloadTangents(w.dv, chunk, &TangentResult::dv);
  });
}

void RolloutEngine::DownloadTangents(const double* from, std::span<TangentResult> results,
                                     RowMatrix TangentResult::*part) const {
  const std::int64_t dofs = resources_.view().num_dofs(), columns = dofs * kPaddedEntries;
  std::vector<double> host(results.size() * columns);
  CopyToHost<double>(from, host);
#pragma omp parallel for num_threads(resources_.threads())
  for (std::size_t i = 0; i < results.size(); ++i) {
    RowMatrix& to = results[i].*part;
    to.resize(dofs, kMaterialEntries);
    resources_.cloth().ToMeshOrder(host.data() + i * columns, kMaterialEntries, kPaddedEntries,
                                   to.data());
  }
}

}  // namespace drape
