// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/readouts/readout_engine.h"

#include <utility>
#include <vector>

#include "cuda/engine/readouts/tangent_reader.h"
#include "cuda/readout/device_readouts.h"

namespace drape {

void ReadoutEngine::ReadoutTangents(std::span<const RolloutInput> batch,
                                    std::span<const MaterialField* const> weights,
                                    const RolloutOptions& options, const Readout& readout,
                                    std::span<ReadoutTangent> results, std::span<char> failed) {
  std::vector<RolloutResult*> ends;
  for (ReadoutTangent& result : results) ends.push_back(&result.rollout);
  const auto read = [&](std::size_t first, std::size_t count, const TangentRun& run) {
    std::vector<const Eigen::VectorXd*> shapes;
    std::vector<LinearReadout*> reads;
    for (std::size_t i = first; i < first + count; ++i) {
      const bool ended = failed[i] == 0 && results[i].rollout.status == RolloutStatus::kOk;
      shapes.push_back(ended ? &results[i].rollout.end.x : nullptr);
      reads.push_back(&results[i].read);
    }
    ReadTangentShapes(resources_, {run.workspace.x, run.dx, shapes}, ReadoutFrom(readout, first),
                      reads);
  };
  rollouts_.ForEachTangentChunk(batch, weights, options, ends, failed, read);
}

void ReadoutEngine::EquilibriumReadoutTangents(std::span<const RolloutInput> batch,
                                               std::span<const MaterialField* const> weights,
                                               const Readout& readout,
                                               std::span<LinearReadout> results) {
  const auto read = [&](std::size_t first, std::size_t count,
                        const EquilibriumEngine::TangentRun& run) {
    std::vector<const Eigen::VectorXd*> shapes;
    std::vector<LinearReadout*> reads;
    for (std::size_t i = 0; i < count; ++i) {
      shapes.push_back(run.solved[i] ? &batch[first + i].start->x : nullptr);
      reads.push_back(&results[first + i]);
    }
    ReadTangentShapes(resources_, {run.x, run.dx, shapes}, ReadoutFrom(readout, first), reads);
  };
  equilibria_.ForEachTangentChunk(batch, weights, read);
}

void ReadoutEngine::LossGradients(std::span<const RolloutInput> batch,
                                  const RolloutOptions& options, const ReadoutLoss& loss,
                                  std::span<LossGradient> results, std::span<char> failed) {
  const bool with_factors = ChooseHistory(resources_, batch.size(), options.steps).with_factors;
  const std::size_t reserve = LossBytes(*loss.readout->device(0)) +
                              (with_factors ? FactorBytes(resources_.cloth(), options.steps) : 0);
  rollouts_.ForEachAdjointChunk(
      batch.size(), 1, options.steps, reserve, [&](std::size_t first, std::size_t count) {
        LossChunk(batch.subspan(first, count), options, {true, with_factors}, loss, first,
                  results.subspan(first, count), failed.subspan(first, count));
      });
}

std::size_t ReadoutEngine::LossBytes(const DeviceReadout& readout) const {
  const std::size_t of_silhouette =
      readout.kind == ReadoutKind::kSoftSilhouette
          ? DeviceSilhouettes::BytesOfSlot(resources_.cloth(), readout)
          : 0;
  return of_silhouette + sizeof(double) * (resources_.view().num_dofs() + readout.size);
}

void ReadoutEngine::LossChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                              HistoryChoice choice, const ReadoutLoss& loss, std::size_t first,
                              std::span<LossGradient> results, std::span<char> failed) {
  const int slots = static_cast<int>(batch.size());
  const RolloutRun run = rollouts_.RunRollouts(batch, options, choice, true);
  if (run.steps < options.steps) {
    for (LossGradient& result : results) result.status = RolloutStatus::kCancelled;
    return;
  }
  const ShapesToRead shapes{&resources_.cloth(), run.workspace.x,
                            CollectDeviceReadouts(*loss.readout, first, batch.size())};
  DeviceLosses losses(shapes, std::span(loss.targets).subspan(first, batch.size()), loss.sigma);
  const std::vector<int> read = MeasureLosses(shapes, &losses, resources_.stream());
  std::vector<int> rollout_failed(slots);
  CopyToHost<int>(run.workspace.failed, rollout_failed);
  const std::vector<Recording> recordings = MakeRecordings(run.history, run.steps);
  std::vector<const Recording*> kept;
  for (const Recording& recording : recordings) kept.push_back(&recording);
  const std::size_t bytes = sizeof(double) * slots * resources_.view().num_dofs();
  const auto write_dL_dx = [&](double* to) {
    CUDA_CHECK(
        cudaMemcpyAsync(to, losses.dL_dx(0), bytes, cudaMemcpyDeviceToDevice, resources_.stream()));
  };
  AdjointRun back = rollouts_.RunAdjoint(batch, kept, 1, write_dL_dx, options);
  const std::vector<double> value = losses.Download();
  for (int i = 0; i < slots; ++i) {
    failed[i] = rollout_failed[i] != 0 || back.failed[i] != 0 || read[i] == kNoRoom;
    results[i] = {};
    if (back.steps < options.steps) results[i].status = RolloutStatus::kCancelled;
    if (back.steps < options.steps || failed[i] || read[i] != kRead) continue;
    results[i].loss = value[i];
    results[i].material = back.sums.Collect(batch[i], i, 1);
  }
}

}  // namespace drape
