// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reductions over a block of threads in a fixed order.

namespace drape {

constexpr int kReduceThreads = 256;

template <class Combine>
__device__ __forceinline__ double ReduceBlock(double value, const Combine& combine) {
  __shared__ double part[kReduceThreads];
  part[threadIdx.x] = value;
  __syncthreads();
  for (int half = kReduceThreads / 2; half > 0; half >>= 1) {
    if (threadIdx.x < half)
      part[threadIdx.x] = combine(part[threadIdx.x], part[threadIdx.x + half]);
    __syncthreads();
  }
  const double result = part[0];
  __syncthreads();
  return result;
}
__device__ __forceinline__ double SumOfBlock(double value) {
  return ReduceBlock(value, [](double a, double b) { return a + b; });
}
// NaN wins.
__device__ __forceinline__ double LargestOfBlock(double value) {
  return ReduceBlock(value, [](double a, double b) { return a > b || a != a ? a : b; });
}

}  // namespace drape
