// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/frames.h"

#include <glog/logging.h>

#include <algorithm>

#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

std::vector<FrameStop> StopsForwards(const RolloutOptions& options) {
  std::vector<FrameStop> stops;
  for (const int step : options.frames) stops.push_back({step, static_cast<int>(stops.size())});
  return stops;
}

std::vector<FrameStop> StopsBackwards(const RolloutOptions& options, int steps) {
  std::vector<FrameStop> stops;
  for (int k = static_cast<int>(options.frames.size()) - 1; k >= 0; --k)
    if (options.frames[k] <= steps) stops.push_back({steps - options.frames[k], k});
  return stops;
}

int RunToFrames(const DeviceResources& resources, const Graph& graph, int steps,
                const RolloutOptions& options, std::span<const FrameStop> stops,
                const std::function<void(int frame)>& at_frame) {
  int done = 0;
  for (const auto& [after, frame] : stops) {
    done += resources.RunSteps(graph, after - done, options.cancel);
    if (done < after) return done;
    at_frame(frame);
  }
  return done + resources.RunSteps(graph, steps - done, options.cancel);
}

void FrameStates::Keep(const DeviceResources& resources, const double* x, const double* v) {
  const auto copy = [&](const double* from, double* to) {
    CUDA_CHECK(cudaMemcpyAsync(to + kept_ * size_, from, size_ * sizeof(double),
                               cudaMemcpyDeviceToDevice, resources.stream()));
  };
  copy(x, x_.data());
  copy(v, v_.data());
  ++kept_;
}

void FrameStates::Download(DeviceResources& resources,
                           std::span<RolloutResult* const> results) const {
  for (std::size_t k = 0; k < kept_; ++k) {
    resources.DownloadEnds(x_.data() + k * size_, v_.data() + k * size_, results);
    for (RolloutResult* result : results) result->frames.push_back(result->end);
  }
}

SeedUpload::SeedUpload(DeviceResources& resources, std::span<const RolloutInput> batch, int m,
                       int columns)
    : resources_(resources), batch_(batch), m_(m), columns_(columns) {
  const bool any = std::ranges::any_of(batch, [](const RolloutInput& input) {
    return input.adjoint != nullptr && !input.adjoint->frames.empty();
  });
  if (!any) return;
  host_.resize(batch.size() * resources.view().num_dofs() * columns);
  seeds_ = DeviceBuffer<double>(host_.size());
}

void SeedUpload::Add(const LaunchContext& on, int frame, double* adj_x, double* adj_v) {
  if (host_.empty()) return;
  Add(on, frame, &FrameSeeds::x, adj_x);
  Add(on, frame, &FrameSeeds::v, adj_v);
}

void SeedUpload::Add(const LaunchContext& on, int frame, RowMatrix FrameSeeds::*part, double* to) {
  const int dofs = on.cloth.num_dofs();
  const std::size_t stride = static_cast<std::size_t>(dofs) * columns_;
  bool any = false;
  std::ranges::fill(host_, 0.0);
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const AdjointOptions* adjoint = batch_[i].adjoint;
    if (adjoint == nullptr || adjoint->frames.empty()) continue;
    const RowMatrix& seeds = adjoint->frames[frame].*part;
    if (seeds.size() == 0) continue;
    CHECK(seeds.rows() == dofs && seeds.cols() == m_) << "FrameSeeds";
    resources_.cloth().ToEliminationOrder(seeds.data(), m_, columns_, host_.data() + i * stride);
    any = true;
  }
  if (!any) return;
  resources_.streams().Synchronize();  // the kernel before has read the buffer
  CopyToDevice<double>(host_, seeds_.data());
  LaunchAddSeeds(on, seeds_.data(), to, columns_);
}

}  // namespace drape
