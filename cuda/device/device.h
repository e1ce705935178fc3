// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cuda/device/cuda_error.h"

namespace drape {

struct DeviceInfo {
  int index = 0;
  std::string name;
  int major = 0, minor = 0;  // compute capability
  int shared_bytes = 0;      // of a block of threads
  std::size_t memory = 0;
};

// The devices that this build has code for (compute capability 8.0 and later); none without a
// driver. *why, when given, says what was found instead.
std::vector<DeviceInfo> FindDevices(std::string* why = nullptr);

struct MemoryStatus {
  std::size_t free, total;  // [bytes]
};
MemoryStatus QueryMemory();

// Throws DeviceMemoryError with the numbers when there is no room.
inline void* AllocateOnDevice(std::size_t bytes) {
  void* data = nullptr;
  const cudaError_t status = cudaMalloc(&data, bytes);
  if (status != cudaErrorMemoryAllocation) {
    CheckCuda(status, "cudaMalloc");
    return data;
  }
  (void)cudaGetLastError();  // the error is reported here
  const auto [free, total] = QueryMemory();
  throw DeviceMemoryError("a batch", bytes, free, total);
}

// Synchronous copies that all streams see.
template <class T>
void CopyToDevice(std::span<const T> from, T* to) {
  if (from.empty()) return;
  CUDA_CHECK(cudaMemcpy(to, from.data(), from.size_bytes(), cudaMemcpyHostToDevice));
  CUDA_CHECK(cudaStreamSynchronize(cudaStreamLegacy));
}
template <class T>
void CopyToHost(const T* from, std::span<T> to) {
  if (to.empty()) return;
  CUDA_CHECK(cudaMemcpy(to.data(), from, to.size_bytes(), cudaMemcpyDeviceToHost));
}
template <class T>
std::vector<T> Download(const T* from, std::size_t count) {
  std::vector<T> host(count);
  CopyToHost<T>(from, host);
  return host;
}

// Device memory of `size` numbers, of the device that is current when it is made. Move-only.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  explicit DeviceBuffer(std::size_t size) : size_(size) {
    if (size > 0) data_ = static_cast<T*>(AllocateOnDevice(bytes()));
  }
  explicit DeviceBuffer(std::span<const T> host) : DeviceBuffer(host.size()) {
    CopyToDevice(host, data_);
  }
  explicit DeviceBuffer(const std::vector<T>& host) : DeviceBuffer(std::span<const T>(host)) {}
  DeviceBuffer(DeviceBuffer&& other) noexcept { *this = std::move(other); }
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~DeviceBuffer() { cudaFree(data_); }

  T* data() { return data_; }
  const T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return size_ * sizeof(T); }

  // At least `size` numbers; what was there is lost when it grows.
  void Reserve(std::size_t size) {
    if (size <= size_) return;
    *this = DeviceBuffer();
    *this = DeviceBuffer(size);
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

// Copies of arrays of the host on the device, which live as long as the object. Move-only.
class DeviceArrays {
 public:
  template <class T>
  const T* Upload(std::span<const T> host) {
    T* copy = reinterpret_cast<T*>(arrays_.emplace_back(host.size_bytes()).data());
    CopyToDevice(host, copy);
    return copy;
  }
  template <class T>
  const T* Upload(const std::vector<T>& host) {
    return Upload(std::span<const T>(host));
  }

 private:
  std::vector<DeviceBuffer<char>> arrays_;
};

// Numbers of the host that the device copies at full speed. Move-only.
template <class T>
class PinnedBuffer {
 public:
  // The first `size` numbers; what was there is lost when it grows.
  std::span<T> Take(std::size_t size) {
    if (size > size_) {
      data_.reset();
      size_ = 0;
      void* data = nullptr;
      CUDA_CHECK(cudaMallocHost(&data, size * sizeof(T)));
      data_.reset(static_cast<T*>(data));
      size_ = size;
    }
    return {data_.get(), size};
  }

 private:
  struct Free {
    void operator()(T* data) const { cudaFreeHost(data); }
  };
  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
};

// All zeros, which all streams see.
template <class T>
void Clear(DeviceBuffer<T>& buffer) {
  if (buffer.size() == 0) return;
  CUDA_CHECK(cudaMemset(buffer.data(), 0, buffer.bytes()));
  CUDA_CHECK(cudaStreamSynchronize(cudaStreamLegacy));
}

// Hands out pieces of one block of device memory. A workspace is a struct that takes its arrays
// from an arena: once from an empty one, to learn how large it is, then from one that holds it.
class Arena {
 public:
  Arena() = default;
  explicit Arena(DeviceBuffer<char>* memory) : base_(memory->data()), capacity_(memory->size()) {}

  template <class T>
  T* Take(std::size_t count) {
    T* piece = base_ == nullptr ? nullptr : reinterpret_cast<T*>(base_ + used_);
    used_ += (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    return piece;
  }
  std::size_t used() const { return used_; }
  bool fits() const { return used_ <= capacity_; }

 private:
  static constexpr std::size_t kAlignment = 256;
  char* base_ = nullptr;
  std::size_t capacity_ = 0, used_ = 0;
};

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
