// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace drape {

struct DeviceInfo {
  int index = 0;
  std::string name;
  int major = 0, minor = 0;  // compute capability
  int multiprocessors = 0;
  int shared_bytes = 0;  // of a block of threads
  std::size_t memory = 0;
};

// The devices that this build has code for (compute capability 8.0 and later); none without a
// driver. *why, when given, says what was found instead.
std::vector<DeviceInfo> FindDevices(std::string* why = nullptr);

struct MemoryStatus {
  std::size_t free, total;  // [bytes]
};
MemoryStatus QueryMemory();

// One stream, and side streams that share its work: slots in groups, which run side by side.
class Streams {
 public:
  Streams();
  ~Streams();
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

  cudaStream_t main() const { return main_; }
  void Synchronize() const;

  // Calls work(first slot, slots, stream) for each group; the main stream waits for all.
  using GroupWork = std::function<void(int first, int slots, cudaStream_t stream)>;
  void ForEachGroup(int slots, const GroupWork& work) const;

 private:
  static constexpr int kGroups = 4, kLeastSlots = 16;  // of a group
  cudaStream_t main_ = nullptr, side_[kGroups] = {};
  cudaEvent_t begin_ = nullptr, end_[kGroups] = {};
};

// A sequence of launches, captured once and replayed.
class Graph {
 public:
  // Captures what `record` launches on streams.main() and what forks from it.
  Graph(const Streams& streams, const std::function<void()>& record);
  ~Graph();
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  void Launch(cudaStream_t stream) const;

 private:
  cudaGraphExec_t executable_ = nullptr;
};

}  // namespace drape
