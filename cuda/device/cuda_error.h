// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <stdexcept>
#include <string>

namespace drape {

// A call of the CUDA runtime failed: no device, no memory, a fault. The tools print what() and exit
// with 2.
class CudaError : public std::runtime_error {
 public:
  CudaError(cudaError_t code, const std::string& what)
      : std::runtime_error("cuda: " + what + ": " + cudaGetErrorString(code)), code_(code) {}
  cudaError_t code() const { return code_; }

 private:
  cudaError_t code_;
};

// Something does not fit into the device's memory [bytes].
class DeviceMemoryError : public std::runtime_error {
 public:
  DeviceMemoryError(const std::string& what, std::size_t needed, std::size_t free,
                    std::size_t total)
      : std::runtime_error("cuda: " + what + " needs " + Megabytes(needed) + " of device memory, " +
                           Megabytes(free) + " of " + Megabytes(total) +
                           " are free: use the cpu backend, a smaller batch or a coarser mesh") {}

 private:
  static std::string Megabytes(std::size_t bytes) { return std::to_string(bytes >> 20) + " MB"; }
};

inline void CheckCuda(cudaError_t code, const char* call) {
  if (code != cudaSuccess) throw CudaError(code, call);
}
#define CUDA_CHECK(call) ::drape::CheckCuda(call, #call)

template <class Kernel>
void AllowSharedMemory(Kernel* kernel, int bytes) {
  CUDA_CHECK(cudaFuncSetAttribute(reinterpret_cast<const void*>(kernel),
                                  cudaFuncAttributeMaxDynamicSharedMemorySize, bytes));
}

}  // namespace drape
