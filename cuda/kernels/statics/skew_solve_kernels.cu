// SPDX-License-Identifier: Apache-2.0
// Vectors of the solves with a slightly unsymmetric stiffness (physics/linalg/cgw_recurrence.h).
#include "cuda/device/cuda_error.h"
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/reduce.cuh"
#include "cuda/kernels/statics/statics_kernels.h"

namespace drape {
namespace {

// A block has one column of one slot.
__global__ void __launch_bounds__(kReduceThreads)
    ColumnDots(int dofs, const double* a, const double* b, double* dots, int columns) {
  const int j = blockIdx.x, slot = blockIdx.y;
  const std::int64_t first = static_cast<std::int64_t>(slot) * dofs * columns + j;
  double sum = 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    const std::int64_t at = first + static_cast<std::int64_t>(i) * columns;
    sum += a[at] * b[at];
  }
  sum = SumOfBlock(sum);
  if (threadIdx.x == 0) dots[slot * columns + j] = sum;
}

__global__ void CgwAdvance(int dofs, const double* weights, const double* step, double* before,
                           double* x, int columns) {
  const std::int64_t i = static_cast<std::int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  const std::int64_t count = static_cast<std::int64_t>(dofs) * columns;
  if (i >= count) return;
  const double weight = weights[blockIdx.y * columns + i % columns];
  if (weight < 0.0) return;
  const std::int64_t at = blockIdx.y * count + i;
  const double now = x[at], old = before[at];
  x[at] = old + weight * (step[at] + now - old);
  before[at] = now;
}

__global__ void __launch_bounds__(kReduceThreads)
    PowerStep(int dofs, double* all_images, double* all_directions, double* radius) {
  double* image = NodesOf(all_images, blockIdx.x, dofs);
  double* direction = NodesOf(all_directions, blockIdx.x, dofs);
  double old_square = 0.0, square = 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    image[i] += direction[i];
    old_square += direction[i] * direction[i];
    square += image[i] * image[i];
  }
  old_square = SumOfBlock(old_square);
  square = SumOfBlock(square);
  const bool grows = square > 0.0;
  const double scale = grows ? 1.0 / ::sqrt(square) : 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    direction[i] = scale * image[i];
    image[i] = 0.0;
  }
  if (threadIdx.x == 0) radius[blockIdx.x] = grows ? ::sqrt(square / old_square) : 0.0;
}

}  // namespace

void LaunchColumnDots(const LaunchContext& on, const double* a, const double* b, double* dots,
                      int columns) {
  ColumnDots<<<dim3(columns, on.batch.slots), kReduceThreads, 0, on.stream>>>(on.cloth.num_dofs(),
                                                                              a, b, dots, columns);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchCgwAdvance(const LaunchContext& on, const double* weight, const double* step,
                      double* before, double* x, int columns) {
  const dim3 grid(BlocksFor(on.cloth.num_dofs() * columns), on.batch.slots);
  CgwAdvance<<<grid, kElementThreads, 0, on.stream>>>(on.cloth.num_dofs(), weight, step, before, x,
                                                      columns);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchCopy(const double* from, double* to, std::int64_t count, cudaStream_t stream) {
  CUDA_CHECK(cudaMemcpyAsync(to, from, count * sizeof(double), cudaMemcpyDeviceToDevice, stream));
}

void LaunchPowerStep(const LaunchContext& on, double* image, double* direction, double* radius) {
  PowerStep<<<on.batch.slots, kReduceThreads, 0, on.stream>>>(on.cloth.num_dofs(), image, direction,
                                                              radius);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
