// SPDX-License-Identifier: Apache-2.0
// Triangular solves with stored factors: one block of threads for each (front, slot), one
// right-hand side at a time.
#include "cuda/device/cuda_error.h"
#include "cuda/factor/multifrontal_kernels.h"
#include "cuda/factor/tensor_core.cuh"

namespace drape {
namespace {

// A front of one slot with its numbers.
struct SolveWork {
  const PlanView& plan;
  const Front& front;
  const double* panel;  // [p + q, p]
  double* solution;     // the slot's [dofs]

  __device__ SolveWork(const PlanView& plan, int front_index, const FactorPlace& factor,
                       double* solution)
      : plan(plan),
        front(plan.fronts[front_index]),
        panel(factor.Of(plan, blockIdx.y) + front.factor_offset),
        solution(solution + static_cast<std::int64_t>(blockIdx.y) * plan.num_dofs) {}
  __device__ double* pivots() const { return solution + front.first_dof; }
};

// The sum of the children's vectors at row r of the front.
__device__ double SumOfChildren(const SolveWork& work, const double* vectors, int r) {
  const int rows = work.front.pivots + work.front.border;
  const int children = work.front.child_end - work.front.child_start;
  const int* source = work.plan.source + work.front.source_start + r;
  double sum = 0.0;
#pragma unroll 2
  for (int k = 0; k < children; ++k) {
    const int from = source[k * rows];
    if (from >= 0) sum += vectors[from];
  }
  return sum;
}

// y ← L11⁻¹·y by one warp; diagonal blocks hold inverses. L11 has rows of `stride` numbers.
__device__ void SolveLower(const double* L11, int stride, int pivots, double* y) {
  const Lane lane = LaneOfWarp();
  for (int first = 0; first < pivots; first += 8) {
    const double* block = L11 + (first + lane.g) * stride + first + 2 * lane.t;
    double value = block[0] * y[first + 2 * lane.t] + block[1] * y[first + 2 * lane.t + 1];
    value += ShuffleXor(value, 1);
    value += ShuffleXor(value, 2);
    __syncwarp();
    if (lane.t == 0) y[first + lane.g] = value;
    __syncwarp();
    for (int r = first + 8 + static_cast<int>(threadIdx.x & 31); r < pivots; r += 32) {
      double product = 0.0;
#pragma unroll
      for (int k = 0; k < 8; ++k) product += L11[r * stride + first + k] * y[first + k];
      y[r] -= product;
    }
    __syncwarp();
  }
}

// y ← L11⁻ᵀ·y by one warp.
__device__ void SolveLowerTransposed(const double* L11, int stride, int pivots, double* y) {
  const Lane lane = LaneOfWarp();
  for (int first = pivots - 8; first >= 0; first -= 8) {
    const double* block = L11 + (first + 2 * lane.t) * stride + first + lane.g;
    double value = block[0] * y[first + 2 * lane.t] + block[stride] * y[first + 2 * lane.t + 1];
    value += ShuffleXor(value, 1);
    value += ShuffleXor(value, 2);
    __syncwarp();
    if (lane.t == 0) y[first + lane.g] = value;
    __syncwarp();
    for (int c = static_cast<int>(threadIdx.x & 31); c < first; c += 32) {
      double even = 0.0, odd = 0.0;
#pragma unroll
      for (int k = 0; k < 8; k += 2) {
        even += L11[(first + k) * stride + c] * y[first + k];
        odd += L11[(first + k + 1) * stride + c] * y[first + k + 1];
      }
      y[c] -= even + odd;
    }
    __syncwarp();
  }
}

// Rows of L11 in shared memory, p + 1 numbers each, up to the end of the diagonal block.
__device__ void LoadLower(const SolveWork& work, double* L11) {
  const int pivots = work.front.pivots, lane = threadIdx.x & 31;
  for (int r = threadIdx.x >> 5; r < pivots; r += blockDim.x >> 5)
    for (int c = lane; c <= (r | 7); c += 32)
      L11[r * (pivots + 1) + c] = work.panel[r * pivots + c];
}

__global__ void ForwardFronts(PlanView plan, int first, FactorPlace factor, const double* rhs,
                              double* solution, double* all_vectors) {
  extern __shared__ __align__(16) double shared[];
  const SolveWork work(plan, plan.level_front[first + blockIdx.x], factor, solution);
  const Front& front = work.front;
  const int pivots = front.pivots, lane = threadIdx.x & 31;
  double* vectors = all_vectors + static_cast<std::int64_t>(blockIdx.y) * plan.vector_size;
  const double* b = rhs + static_cast<std::int64_t>(blockIdx.y) * plan.num_dofs + front.first_dof;
  double *y = shared, *L11 = shared + pivots;
  LoadLower(work, L11);
  for (int r = threadIdx.x; r < pivots; r += blockDim.x)
    y[r] = (r < front.true_pivots ? b[r] : 0.0) + SumOfChildren(work, vectors, r);
  __syncthreads();
  if (threadIdx.x < 32) SolveLower(L11, pivots + 1, pivots, y);
  __syncthreads();
  for (int r = threadIdx.x; r < front.true_pivots; r += blockDim.x) work.pivots()[r] = y[r];
  // Four border rows a warp, eight lanes each.
  const int part = lane & 7;
  for (int i0 = 4 * (threadIdx.x >> 5); i0 < front.border; i0 += 4 * (blockDim.x >> 5)) {
    const int i = i0 + (lane >> 3);
    double product = 0.0;
    if (i < front.border) {
      const double* row = work.panel + static_cast<std::int64_t>(pivots + i) * pivots;
      for (int k = 2 * part; k < pivots; k += 16) product += row[k] * y[k] + row[k + 1] * y[k + 1];
    }
    product += ShuffleXor(product, 1);
    product += ShuffleXor(product, 2);
    product += ShuffleXor(product, 4);
    if (part == 0 && i < front.border)
      vectors[front.vector_offset + i] = SumOfChildren(work, vectors, pivots + i) - product;
  }
}

constexpr int kAhead = 8;  // rows of L21 in flight

__global__ void __launch_bounds__(256, 4)
    BackwardFronts(PlanView plan, int first, FactorPlace factor, double* solution) {
  extern __shared__ __align__(16) double shared[];
  const SolveWork work(plan, plan.level_front[first + blockIdx.x], factor, solution);
  const Front& front = work.front;
  const int pivots = front.pivots, border = front.border;
  double *L11 = shared, *y = shared + pivots * (pivots + 1), *x = y + pivots, *sums = x + border;
  // y −= L21ᵀ·x: each group of p / 2 threads has every `groups`-th row, two columns a thread. The
  // first rows are read before x is known.
  const int pairs = pivots / 2, groups = blockDim.x / pairs, group = threadIdx.x / pairs;
  const int pair = threadIdx.x - group * pairs, end = group < groups ? border : 0;
  const double2* L21 =
      reinterpret_cast<const double2*>(work.panel + static_cast<std::int64_t>(pivots) * pivots) +
      pair;
  double2 ahead[kAhead];
#pragma unroll
  for (int u = 0; u < kAhead; ++u)
    if (const int i = group + u * groups; i < end) ahead[u] = L21[i * pairs];
  for (int i = threadIdx.x; i < border; i += blockDim.x) {
    const int dof = plan.border_dof[front.border_start + i];
    x[i] = dof >= 0 ? work.solution[dof] : 0.0;
  }
  LoadLower(work, L11);
  for (int r = threadIdx.x; r < pivots; r += blockDim.x)
    y[r] = r < front.true_pivots ? work.pivots()[r] : 0.0;
  __syncthreads();
  double2 sum = {0.0, 0.0};
  for (int first = group; first < end; first += kAhead * groups) {
#pragma unroll
    for (int u = 0; u < kAhead; ++u)
      if (const int i = first + u * groups; i < end) {
        sum.x += ahead[u].x * x[i];
        sum.y += ahead[u].y * x[i];
        if (const int next = i + kAhead * groups; next < end) ahead[u] = L21[next * pairs];
      }
  }
  if (group < groups) reinterpret_cast<double2*>(sums)[group * pairs + pair] = sum;
  __syncthreads();
  for (int r = threadIdx.x; r < pivots; r += blockDim.x) {
    double all = 0.0;
    for (int k = 0; k < groups; ++k) all += sums[k * pivots + r];
    y[r] -= all;
  }
  __syncthreads();
  if (threadIdx.x < 32) SolveLowerTransposed(L11, pivots + 1, pivots, y);
  __syncthreads();
  for (int r = threadIdx.x; r < front.true_pivots; r += blockDim.x) work.pivots()[r] = y[r];
}

}  // namespace

void PrepareSolveKernels(int shared_bytes) {
  AllowSharedMemory(ForwardFronts, shared_bytes);
  AllowSharedMemory(BackwardFronts, shared_bytes);
}

void LaunchForwardLevel(const LevelLaunch& on, const FactorPlace& factor, const double* rhs,
                        double* solution, double* vectors) {
  ForwardFronts<<<dim3(on.level.end - on.level.begin, on.slots), 128, on.level.shared_solve,
                  on.stream>>>(on.plan, on.level.begin, factor, rhs, solution, vectors);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchBackwardLevel(const LevelLaunch& on, const FactorPlace& factor, double* solution) {
  BackwardFronts<<<dim3(on.level.end - on.level.begin, on.slots), 256, on.level.shared_solve,
                   on.stream>>>(on.plan, on.level.begin, factor, solution);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
