// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/resources/device_resources.h"

#include <algorithm>
#include <utility>

namespace drape {

DeviceResources::DeviceResources(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                                 const DeviceInfo& device, int threads)
    : device_(device), threads_(threads) {
  Bind();
  cloth_ = std::make_unique<DeviceCloth>(std::move(model), plan, device.shared_bytes);
  streams_ = std::make_unique<Streams>();
}

void DeviceResources::Bind() const { CUDA_CHECK(cudaSetDevice(device_.index)); }

std::size_t DeviceResources::FreeBytes() const {
  Bind();
  return QueryMemory().free + memory_.bytes();
}

int DeviceResources::SlotsThatFit(int wanted, const TakeWorkspace& take,
                                  std::size_t reserve) const {
  constexpr double kUsable = 0.9;  // the rest is for the driver, graphs and other programs
  const MemoryStatus memory = QueryMemory();
  const auto usable = static_cast<std::size_t>(kUsable * (memory.free + memory_.bytes()));
  const auto needed = [&](int slots) {
    Arena measure;
    take(measure, slots);
    return measure.used() + slots * reserve;
  };
  if (needed(1) > usable)
    throw DeviceMemoryError("one rollout of this mesh", needed(1), usable, memory.total);
  int fits = 1, too_many = wanted + 1;
  while (too_many - fits > 1) {
    const int middle = fits + (too_many - fits) / 2;
    (needed(middle) <= usable ? fits : too_many) = middle;
  }
  // Even chunks rather than full ones and a rest.
  const int chunks = (wanted + fits - 1) / fits;
  return (wanted + chunks - 1) / chunks;
}

void DeviceResources::ForEachChunk(std::size_t count, const TakeWorkspace& take,
                                   std::size_t reserve, const ChunkWork& work) const {
  Bind();
  const int most = SlotsThatFit(static_cast<int>(count), take, reserve);
  for (std::size_t first = 0; first < count; first += most)
    work(first, std::min<std::size_t>(most, count - first));
}

void DeviceResources::Allocate(int slots, const TakeWorkspace& take) {
  Arena measure;
  take(measure, slots);
  memory_.Reserve(measure.used());
  Arena arena(&memory_);
  take(arena, slots);
}

void DeviceResources::UploadStarts(std::span<const RolloutInput> batch, double* x, double* v) {
  const std::size_t dofs = view().num_dofs(), size = batch.size() * dofs;
  const std::span<double> host = staging_.Take(size);
  const auto upload = [&](Eigen::VectorXd State::*part, double* to) {
#pragma omp parallel for num_threads(threads_)
    for (std::size_t i = 0; i < batch.size(); ++i)
      cloth_->ToEliminationOrder((batch[i].start->*part).data(), 1, 1, host.data() + i * dofs);
    CUDA_CHECK(
        cudaMemcpyAsync(to, host.data(), host.size_bytes(), cudaMemcpyHostToDevice, stream()));
    streams_->Synchronize();
  };
  upload(&State::x, x);
  if (v != nullptr) upload(&State::v, v);
}

void DeviceResources::DownloadEnds(const double* x, const double* v,
                                   std::span<RolloutResult* const> results) {
  const std::size_t dofs = view().num_dofs(), size = results.size() * dofs;
  const std::span<double> host = staging_.Take(size);
  const auto download = [&](const double* from, Eigen::VectorXd State::*part) {
    CUDA_CHECK(
        cudaMemcpyAsync(host.data(), from, host.size_bytes(), cudaMemcpyDeviceToHost, stream()));
    streams_->Synchronize();
#pragma omp parallel for num_threads(threads_)
    for (std::size_t i = 0; i < results.size(); ++i) {
      Eigen::VectorXd& to = results[i]->end.*part;
      to.resize(static_cast<Eigen::Index>(dofs));
      cloth_->ToMeshOrder(host.data() + i * dofs, 1, 1, to.data());
    }
  };
  download(x, &State::x);
  download(v, &State::v);
}

void DeviceResources::Clear(void* data, std::size_t bytes) const {
  CUDA_CHECK(cudaMemsetAsync(data, 0, bytes, stream()));
}

int DeviceResources::RunSteps(const Graph& graph, int steps,
                              const std::atomic<bool>* cancel) const {
  constexpr int kStepsAhead = 16;  // of the host, where it must be able to stop
  for (int k = 0; k < steps; ++k) {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return k;
    graph.Launch(stream());
    if (cancel != nullptr && k % kStepsAhead == kStepsAhead - 1) streams_->Synchronize();
  }
  return steps;
}

std::vector<const MaterialField*> CollectMaterials(std::span<const RolloutInput> batch) {
  std::vector<const MaterialField*> materials;
  for (const RolloutInput& input : batch) materials.push_back(input.material);
  return materials;
}

ShapeBatch SliceBatch(const ShapeBatch& batch, int first, int slots, int num_dofs) {
  ShapeBatch group = batch;
  group.slots = slots;
  if (batch.rollout != nullptr) {
    group.rollout += first;
  } else {
    group.material += first;
    group.x += static_cast<std::int64_t>(first) * num_dofs;
  }
  return group;
}

}  // namespace drape
