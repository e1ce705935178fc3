// SPDX-License-Identifier: Apache-2.0
// What losses read of a batch's shapes: derivatives of a readout, and losses with their gradients.
#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "cuda/engine/adjoint_workspace.h"
#include "cuda/engine/device_gradient.h"
#include "cuda/readout/device_readouts.h"

namespace drape {
namespace {

// Of the rollouts [first, first + count); all of one kind.
std::vector<const DeviceReadout*> DeviceReadouts(const Readout& readout, std::size_t first,
                                                 std::size_t count) {
  std::vector<const DeviceReadout*> each;
  for (std::size_t i = first; i < first + count; ++i) {
    each.push_back(readout.device(i));
    CHECK(each.back() != nullptr && each.back()->kind == each[0]->kind);
    CHECK_EQ(each.back()->size, readout.size());
    CHECK_EQ(each.back()->width, each[0]->width);
  }
  return each;
}

}  // namespace

void DeviceEngine::ReadTangents(const TangentShapes& shapes, const Readout& readout,
                                std::span<LinearReadout* const> results) const {
  const DeviceReadout* known = readout.device(0);
  if (known != nullptr && known->kind == ReadoutKind::kOutline) {
    ReadOutlineTangents(shapes, readout, results);
  } else {
    ReadTangentsOnHost(shapes, readout, results);
  }
}

void DeviceEngine::ReadOutlineTangents(const TangentShapes& shapes, const Readout& readout,
                                       std::span<LinearReadout* const> results) const {
  const int slots = static_cast<int>(results.size()), rows = readout.size();
  const DeviceOutlines outlines(
      {cloth_.get(), shapes.x, DeviceReadouts(readout, 0, results.size())}, nullptr,
      streams_->main());
  const std::vector<double> radius = outlines.Radius();
  const std::vector<int> status = outlines.Status();
  const std::vector<double> dr = MultiplyRows(outlines.Jacobian(), rows, shapes.dx, slots);
  for (int s = 0; s < slots; ++s) {
    if (shapes.host[s] == nullptr || status[s] != kRead) continue;
    results[s]->r = Eigen::Map<const Eigen::VectorXd>(radius.data() + s * rows, rows);
    results[s]->dr =
        Eigen::Map<const RowMatrix>(dr.data() + s * rows * kPaddedEntries, rows, kPaddedEntries)
            .leftCols(kMaterialEntries);
  }
}

void DeviceEngine::ReadTangentsOnHost(const TangentShapes& shapes, const Readout& readout,
                                      std::span<LinearReadout* const> results) const {
  const int slots = static_cast<int>(results.size()), rows = readout.size();
  std::vector<ReadoutJacobian> jacobians(slots);
  std::vector<char> read(slots);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_)
  for (int i = 0; i < slots; ++i)
    read[i] = shapes.host[i] != nullptr &&
              readout.Read(i, *shapes.host[i], &results[i]->r, &jacobians[i]);
  std::vector<int> start{0}, dof;
  std::vector<double> value;
  for (int i = 0; i < slots; ++i)
    for (int r = 0; r < rows; ++r) {
      if (read[i])
        for (ReadoutJacobian::InnerIterator at(jacobians[i], r); at; ++at) {
          dof.push_back(cloth_->DofInEliminationOrder(static_cast<int>(at.col())));
          value.push_back(at.value());
        }
      start.push_back(static_cast<int>(dof.size()));
    }
  const DeviceBuffer<int> starts(start), dofs(dof);
  const DeviceBuffer<double> values(value);
  const std::vector<double> dr =
      MultiplyRows({starts.data(), dofs.data(), values.data()}, rows, shapes.dx, slots);
  for (int i = 0; i < slots; ++i) {
    if (read[i]) {
      results[i]->dr =
          Eigen::Map<const RowMatrix>(dr.data() + std::size_t{1} * i * rows * kPaddedEntries, rows,
                                      kPaddedEntries)
              .leftCols(kMaterialEntries);
    } else {
      *results[i] = {};
    }
  }
}

std::vector<double> DeviceEngine::MultiplyRows(const SparseRows& sparse, int rows, const double* dx,
                                               int slots) const {
  constexpr std::size_t kMostNumbers = std::size_t{1} << 24;  // at a time: pixels are many rows
  const std::size_t of_slot = std::size_t{kPaddedEntries} * rows;
  const int some = static_cast<int>(std::clamp<std::size_t>(kMostNumbers / of_slot, 1, slots));
  DeviceBuffer<double> out(some * of_slot);
  std::vector<double> host(slots * of_slot);
  for (int first = 0; first < slots; first += some) {
    const int count = std::min(some, slots - first);
    const SparseRows part{sparse.start + std::size_t{1} * first * rows, sparse.dof, sparse.value};
    LaunchReadRows(cloth_->view(), part,
                   dx + std::size_t{kPaddedEntries} * first * cloth_->view().num_dofs(), out.data(),
                   rows, count, streams_->main());
    streams_->Synchronize();
    CopyToHost<double>(out.data(), std::span(host).subspan(first * of_slot, count * of_slot));
  }
  return host;
}

void DeviceEngine::LossGradients(std::span<const RolloutInput> batch, const RolloutOptions& options,
                                 const ReadoutLoss& loss, std::span<LossGradient> results,
                                 std::span<char> failed) {
  Bind();
  const bool with_factors = ChooseHistory(batch.size(), options.steps).with_factors;
  const std::size_t beside = LossBytes(*loss.readout->device(0)) +
                             HistoryBytes(cloth_->view().num_dofs(), options.steps) +
                             (with_factors ? FactorBytes(options.steps) : 0);
  const int most = SlotsThatFit(
      static_cast<int>(batch.size()),
      [&](Arena& arena, int slots) { AdjointWorkspace::Take(arena, *cloth_, slots, 1); }, beside);
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    LossChunk(batch.subspan(first, count), options, {true, with_factors}, loss, first,
              results.subspan(first, count), failed.subspan(first, count));
  }
}

std::size_t DeviceEngine::LossBytes(const DeviceReadout& readout) const {
  const std::size_t of_silhouette = readout.kind == ReadoutKind::kSoftSilhouette
                                        ? DeviceSilhouettes::BytesOfSlot(*cloth_, readout)
                                        : 0;
  return of_silhouette + GradientBytes(cloth_->view(), 1) +
         sizeof(double) * (cloth_->view().num_dofs() + readout.size);
}

void DeviceEngine::LossChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                             HistoryChoice choice, const ReadoutLoss& loss, std::size_t first,
                             std::span<LossGradient> results, std::span<char> failed) {
  const int slots = static_cast<int>(batch.size());
  const RolloutRun run = RunRollouts(batch, options, choice, true);
  if (run.done < options.steps) {
    for (LossGradient& result : results) result.status = RolloutStatus::kCancelled;
    return;
  }
  const ShapesToRead shapes{cloth_.get(), run.workspace.x,
                            DeviceReadouts(*loss.readout, first, batch.size())};
  DeviceLosses losses(shapes, std::span(loss.targets).subspan(first, batch.size()), loss.sigma);
  const std::vector<int> read = MeasureLosses(shapes, &losses, streams_->main());
  std::vector<int> fell(slots);
  CopyToHost<int>(run.workspace.failed, fell);
  const std::vector<Recording> recordings = MakeRecordings(run.history, run.done);
  std::vector<const Recording*> kept;
  for (const Recording& recording : recordings) kept.push_back(&recording);
  const std::size_t bytes = sizeof(double) * slots * cloth_->view().num_dofs();
  AdjointRun back = RunAdjoint(
      batch, kept, 1,
      [&](double* adj_x) {
        CUDA_CHECK(cudaMemcpyAsync(adj_x, losses.seed(0), bytes, cudaMemcpyDeviceToDevice,
                                   streams_->main()));
      },
      options);
  const std::vector<double> value = losses.Download();
  for (int i = 0; i < slots; ++i) {
    failed[i] = fell[i] != 0 || back.failed[i] != 0 || read[i] == kNoRoom;
    results[i] = {};
    if (back.done < options.steps) results[i].status = RolloutStatus::kCancelled;
    if (back.done < options.steps || failed[i] || read[i] != kRead) continue;
    results[i].loss = value[i];
    results[i].material = back.sums.Collect(batch[i], i, 1);
  }
}

}  // namespace drape
