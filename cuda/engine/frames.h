// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"

namespace drape {

// Frames of a batch on a device (RolloutOptions::frames).

// A frame on the way of a graph: how often it has been replayed there.
struct FrameStop {
  int after, frame;
};
// The frames of a pass forwards, and of a pass back from the state after `steps` steps.
std::vector<FrameStop> StopsForwards(const RolloutOptions& options);
std::vector<FrameStop> StopsBackwards(const RolloutOptions& options, int steps);

// Replays `graph` for each step and calls at_frame(frame) at its stops, between launches on the
// main stream. Returns the steps that were done before options.cancel turned true.
int RunToFrames(const DeviceResources& resources, const Graph& graph, int steps,
                const RolloutOptions& options, std::span<const FrameStop> stops,
                const std::function<void(int frame)>& at_frame);

// The states of all slots at the frames, kept on the device until the end of the rollout.
class FrameStates {
 public:
  FrameStates(const ClothView& cloth, int slots, const RolloutOptions& options)
      : size_(static_cast<std::size_t>(slots) * cloth.num_dofs()),
        x_(size_ * options.frames.size()),
        v_(size_ * options.frames.size()) {}
  static std::size_t Bytes(const ClothView& cloth, const RolloutOptions& options) {  // of a slot
    return 2 * sizeof(double) * cloth.num_dofs() * options.frames.size();
  }

  // Copies the present states on the main stream; x and v: [3V] a slot.
  void Keep(const DeviceResources& resources, const double* x, const double* v);
  // Appends the frames that were kept to those of the results. Their ends are overwritten.
  void Download(DeviceResources& resources, std::span<RolloutResult* const> results) const;

 private:
  std::size_t size_, kept_ = 0;
  DeviceBuffer<double> x_, v_;  // [frames, slots, 3V]
};

// The seeds of a frame on their way to the adjoints of a batch.
class SeedUpload {
 public:
  // m columns of seeds, `columns` of the adjoints.
  SeedUpload(DeviceResources& resources, std::span<const RolloutInput> batch, int m, int columns);

  // adj_x, adj_v += the seeds of a frame, [3V, columns] a slot; where a rollout has none, zero.
  void Add(const LaunchContext& on, int frame, double* adj_x, double* adj_v);

 private:
  void Add(const LaunchContext& on, int frame, RowMatrix FrameSeeds::*part, double* to);

  DeviceResources& resources_;
  std::span<const RolloutInput> batch_;
  int m_, columns_;
  std::vector<double> host_;
  DeviceBuffer<double> seeds_;
};

}  // namespace drape
