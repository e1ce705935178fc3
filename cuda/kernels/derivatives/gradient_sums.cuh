// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sums of gradients over the elements of a block of threads, one thread per element.

#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"

namespace drape {

static_assert(kGradientChunk == kElementThreads);
constexpr int kGradientWarps = kGradientChunk / 32;

// Adds the sums over the block to `to`, rows `columns` apart: a fixed tree in each warp, then the
// warps in order.
template <int N>
__device__ void ReduceToRow(const double (&value)[N], double (&scratch)[kGradientWarps][N],
                            double* to, int columns) {
#pragma unroll
  for (int k = 0; k < N; ++k) {
    double sum = value[k];
    for (int offset = 16; offset > 0; offset >>= 1)
      sum += __shfl_down_sync(0xffffffffu, sum, offset);
    if ((threadIdx.x & 31) == 0) scratch[threadIdx.x >> 5][k] = sum;
  }
  __syncthreads();
  if (threadIdx.x < N) {
    double sum = 0.0;
    for (int warp = 0; warp < kGradientWarps; ++warp) sum += scratch[warp][threadIdx.x];
    to[threadIdx.x * static_cast<std::int64_t>(columns)] += sum;
  }
  __syncthreads();
}

// The numbers of one element to the row of the block where one table serves all, or to its own.
template <int N>
__device__ void AddToGradient(const double (&value)[N], bool shared_table, bool acts,
                              double (&scratch)[kGradientWarps][N], double* to, int columns) {
  if (shared_table) {
    ReduceToRow(value, scratch, to, columns);
  } else if (acts) {
#pragma unroll
    for (int k = 0; k < N; ++k) to[k * static_cast<std::int64_t>(columns)] += value[k];
  }
}

}  // namespace drape
