// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/device.h"

#include <algorithm>

namespace drape {
namespace {

constexpr int kLeastMajor = 8;
constexpr int kStaticShared = 1024;  // bytes of a block that kernels may declare themselves

DeviceInfo Describe(int index) {
  cudaDeviceProp properties{};
  CUDA_CHECK(cudaGetDeviceProperties(&properties, index));
  return {index,
          properties.name,
          properties.major,
          properties.minor,
          static_cast<int>(properties.sharedMemPerBlockOptin) - kStaticShared,
          properties.totalGlobalMem};
}

}  // namespace

std::vector<DeviceInfo> FindDevices(std::string* why) {
  int count = 0;
  std::vector<DeviceInfo> usable;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess) {
    if (why != nullptr) *why = cudaGetErrorString(status);
    return usable;
  }
  std::string found = "no CUDA device";
  for (int i = 0; i < count; ++i) {
    DeviceInfo device = Describe(i);
    if (device.major >= kLeastMajor) {
      usable.push_back(std::move(device));
    } else {
      found = device.name + " is older than compute capability 8.0";
    }
  }
  if (why != nullptr) *why = found;
  return usable;
}

MemoryStatus QueryMemory() {
  MemoryStatus status{};
  CUDA_CHECK(cudaMemGetInfo(&status.free, &status.total));
  return status;
}

Streams::Streams() {
  CUDA_CHECK(cudaStreamCreateWithFlags(&main_, cudaStreamNonBlocking));
  CUDA_CHECK(cudaEventCreateWithFlags(&begin_, cudaEventDisableTiming));
  for (int g = 0; g < kGroups; ++g) {
    CUDA_CHECK(cudaStreamCreateWithFlags(&side_[g], cudaStreamNonBlocking));
    CUDA_CHECK(cudaEventCreateWithFlags(&end_[g], cudaEventDisableTiming));
  }
}

Streams::~Streams() {
  for (int g = 0; g < kGroups; ++g) {
    cudaEventDestroy(end_[g]);
    cudaStreamDestroy(side_[g]);
  }
  cudaEventDestroy(begin_);
  cudaStreamDestroy(main_);
}

void Streams::Synchronize() const { CUDA_CHECK(cudaStreamSynchronize(main_)); }

void Streams::ForEachGroup(int slots, const GroupWork& work) const {
  const int groups = std::clamp(slots / kLeastSlots, 1, kGroups);
  if (groups == 1) return work(0, slots, main_);
  CUDA_CHECK(cudaEventRecord(begin_, main_));
  for (int g = 0; g < groups; ++g) {
    const int first = slots * g / groups, last = slots * (g + 1) / groups;
    CUDA_CHECK(cudaStreamWaitEvent(side_[g], begin_, 0));
    work(first, last - first, side_[g]);
    CUDA_CHECK(cudaEventRecord(end_[g], side_[g]));
    CUDA_CHECK(cudaStreamWaitEvent(main_, end_[g], 0));
  }
}

Graph::Graph(const Streams& streams, const std::function<void()>& record) {
  cudaGraph_t graph = nullptr;
  CUDA_CHECK(cudaStreamBeginCapture(streams.main(), cudaStreamCaptureModeThreadLocal));
  record();
  CUDA_CHECK(cudaStreamEndCapture(streams.main(), &graph));
  const cudaError_t status = cudaGraphInstantiate(&executable_, graph, 0);
  cudaGraphDestroy(graph);
  CheckCuda(status, "cudaGraphInstantiate");
}

Graph::~Graph() { cudaGraphExecDestroy(executable_); }

void Graph::Launch(cudaStream_t stream) const { CUDA_CHECK(cudaGraphLaunch(executable_, stream)); }

}  // namespace drape
