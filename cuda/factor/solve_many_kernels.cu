// SPDX-License-Identifier: Apache-2.0
// Triangular solves with stored factors for many right-hand sides, in tiles of sixteen, products on
// the tensor cores. A block of threads has one front of one slot and up to three tiles. It reads
// the front's L21 once, straight from device memory, and keeps L11 and the pivots' right-hand sides
// Y [16·tiles, p] in shared memory: with L21 there too, one block would fill a multiprocessor and
// nothing would hide its latency (measured: twice the time).
#include <algorithm>
#include <initializer_list>

#include "cuda/device/cuda_error.h"
#include "cuda/factor/multifrontal_kernels.h"
#include "cuda/factor/tensor_core.cuh"

namespace drape {
namespace {

constexpr int kColumnTile = 16;
constexpr int kMostTiles = 3;
constexpr int kThreads = 256, kWarps = kThreads / 32;  // a warp for each eight of 64 pivots

// A front of one slot, and the right-hand sides from `first_column` on.
struct ManyWork {
  const PlanView& plan;
  const Front front;    // a copy: the compiler would read it again after each store
  const double* panel;  // [p + q, p]
  int columns;          // right-hand sides of the slot
  int first_column;

  __device__ int stride() const { return front.pivots + 4; }  // of Y: no bank conflicts
  __device__ bool Has(int column) const { return first_column + column < columns; }
  // Place of column `column` of this block at row r of a matrix [rows, columns].
  __device__ std::int64_t At(int r, int column) const {
    return static_cast<std::int64_t>(r) * columns + first_column + column;
  }
};

// Adds the children's vectors at kRows rows of the front from r0 on, for the columns of this lane:
// the loads of all are in flight together.
template <int kRows, int kColumns>
__device__ __forceinline__ void AddChildren(const ManyWork& work, const double* vectors, int r0,
                                            const int (&column)[kColumns],
                                            double (&sum)[kRows][kColumns]) {
  const int rows = work.front.pivots + work.front.border;
  const int children = work.front.child_end - work.front.child_start;
  const int* source = work.plan.source + work.front.source_start + r0;
#pragma unroll 2
  for (int k = 0; k < children; ++k) {
    int from[kRows];
#pragma unroll
    for (int i = 0; i < kRows; ++i) from[i] = source[k * rows + i];
#pragma unroll
    for (int i = 0; i < kRows; ++i)
#pragma unroll
      for (int c = 0; c < kColumns; ++c)
        sum[i][c] +=
            from[i] >= 0 && work.Has(column[c]) ? vectors[work.At(from[i], column[c])] : 0.0;
  }
}

// Calls visit(pivot row, column) for all of Y; neighbouring threads have neighbouring columns.
template <int Tiles, class Visit>
__device__ void ForEachPivot(const ManyWork& work, const Visit& visit) {
  constexpr int kColumns = kColumnTile * Tiles;
  for (int i = threadIdx.x; i < work.front.pivots * kColumns; i += kThreads)
    visit(i / kColumns, i % kColumns);
}

// L11 in shared memory, rows of p + 4.
__device__ void LoadPivotBlock(const ManyWork& work, double* L11) {
  const int half = work.front.pivots / 2, stride = work.stride();
#pragma unroll 4
  for (int i = threadIdx.x; i < work.front.pivots * half; i += kThreads) {
    const int r = i / half, c = 2 * (i - r * half);
    *reinterpret_cast<double2*>(L11 + r * stride + c) =
        *reinterpret_cast<const double2*>(work.panel + 2 * i);
  }
}

// Y ← L11⁻¹·Y for one tile by one warp.
__device__ void ForwardPivots(const ManyWork& work, const double* L11, double* Y) {
  const Lane lane = LaneOfWarp();
  const int stride = work.stride(), pivots = work.front.pivots;
  for (int first = 0; first < pivots; first += 8) {
    double sum[4] = {}, y[4] = {};
    for (int k = 0; k < first; k += 8) {
      double a[4], b[2];
      LoadA(a, Y + k, stride, lane);
      LoadTransposedB(b, L11 + first * stride + k, stride, lane);
      MultiplyAdd(sum, a, b);
    }
    const int c = first + 2 * lane.t;
    double *low = Y + lane.g * stride + c, *high = low + 8 * stride;
    const double a[4] = {low[0] - sum[0], high[0] - sum[2], low[1] - sum[1], high[1] - sum[3]};
    const double* block = L11 + (first + lane.g) * stride + c;
    MultiplyAdd(y, a, {block[0], block[1]});
    low[0] = y[0];
    low[1] = y[1];
    high[0] = y[2];
    high[1] = y[3];
    __syncwarp();
  }
}

// Y ← right-hand sides + children, transposed: a warp has a row, a lane up to two columns, and four
// rows (a multiple of eight a front) are under way at a time.
template <int Tiles>
__device__ void GatherPivots(const ManyWork& work, const double* rhs, const double* vectors,
                             double* Y) {
  constexpr int kRows = 4, kColumns = kColumnTile * Tiles > 32 ? 2 : 1;
  const int lane = threadIdx.x & 31, column[2] = {lane, lane + 32};
  const Front& front = work.front;
  for (int r0 = kRows * (threadIdx.x >> 5); r0 < front.pivots; r0 += kRows * kWarps) {
    double sum[kRows][kColumns];
    int own[kColumns];
#pragma unroll
    for (int c = 0; c < kColumns; ++c) {
      own[c] = column[c];
#pragma unroll
      for (int i = 0; i < kRows; ++i)
        sum[i][c] = r0 + i < front.true_pivots && work.Has(own[c])
                        ? rhs[work.At(front.first_dof + r0 + i, own[c])]
                        : 0.0;
    }
    AddChildren(work, vectors, r0, own, sum);
#pragma unroll
    for (int c = 0; c < kColumns; ++c)
#pragma unroll
      for (int i = 0; i < kRows; ++i)
        if (own[c] < kColumnTile * Tiles) Y[own[c] * work.stride() + r0 + i] = sum[i][c];
  }
}

// Eight border rows: children − L21·Y.
template <int Tiles>
__device__ void ForwardBorder(const ManyWork& work, int first, const double* Y, double* vectors) {
  const Lane lane = LaneOfWarp();
  const int stride = work.stride(), pivots = work.front.pivots;
  const double* L21 = work.panel + static_cast<std::int64_t>(pivots + first) * pivots;
  double product[Tiles][4] = {};
#pragma unroll 2
  for (int k = 0; k < pivots; k += 8) {
    double b[2];
    LoadTransposedB(b, L21 + k, pivots, lane);
#pragma unroll
    for (int tile = 0; tile < Tiles; ++tile) {
      double a[4];
      LoadA(a, Y + kColumnTile * tile * stride + k, stride, lane);
      MultiplyAdd(product[tile], a, b);
    }
  }
  double value[2][2 * Tiles] = {};
  int column[2 * Tiles];
#pragma unroll
  for (int c = 0; c < 2 * Tiles; ++c) column[c] = 8 * c + lane.g;
  AddChildren(work, vectors, pivots + first + 2 * lane.t, column, value);
#pragma unroll
  for (int i = 0; i < 2; ++i)
#pragma unroll
    for (int c = 0; c < 2 * Tiles; ++c)
      if (work.Has(column[c]))
        vectors[work.At(work.front.vector_offset + first + 2 * lane.t + i, column[c])] =
            value[i][c] - product[c / 2][2 * (c % 2) + i];
}

// grid: fronts, slots, chunks of Tiles tiles of right-hand sides.
template <int Tiles>
__global__ void __launch_bounds__(kThreads, 3)
    ForwardManyFronts(PlanView plan, int first, FactorPlace factor, const double* rhs,
                      double* solution, double* vectors, int columns) {
  extern __shared__ __align__(16) double Y[];
  const std::int64_t slot = blockIdx.y, offset = slot * columns * plan.num_dofs;
  const Front front = plan.fronts[plan.level_front[first + blockIdx.x]];
  const ManyWork work{plan, front, factor.Of(plan, slot) + front.factor_offset, columns,
                      kColumnTile * Tiles * static_cast<int>(blockIdx.z)};
  const int stride = work.stride(), warp = threadIdx.x >> 5;
  vectors += slot * columns * plan.vector_size;
  double* L11 = Y + kColumnTile * Tiles * stride;
  LoadPivotBlock(work, L11);
  GatherPivots<Tiles>(work, rhs + offset, vectors, Y);
  __syncthreads();
  if (warp < Tiles) ForwardPivots(work, L11, Y + kColumnTile * warp * stride);
  __syncthreads();
  ForEachPivot<Tiles>(work, [&](int r, int c) {
    if (r < front.true_pivots && work.Has(c))
      solution[offset + work.At(front.first_dof + r, c)] = Y[c * stride + r];
  });
  for (int i = 8 * warp; i < front.border; i += 8 * kWarps)
    ForwardBorder<Tiles>(work, i, Y, vectors);
}

// Border rows of the solution at a time in shared memory, rows of kStagedStride: the two halves of
// a warp meet no bank twice.
constexpr int kStagedRows = 64;
template <int Tiles>
constexpr int kStagedStride = kColumnTile* Tiles + 8;

template <int Tiles>
__device__ void StageBorder(const ManyWork& work, int first, const double* solution,
                            double* staged) {
  constexpr int kColumns = kColumnTile * Tiles;
  const int* border_dof = work.plan.border_dof + work.front.border_start;
  const int rows = min(kStagedRows, work.front.border - first);
  // All loads of a thread are in flight together.
#pragma unroll
  for (int part = 0; part < kStagedRows * kColumns / kThreads; ++part) {
    const int i = threadIdx.x + part * kThreads, r = i / kColumns, c = i % kColumns;
    const int dof = r < rows ? border_dof[first + r] : -1;
    staged[r * kStagedStride<Tiles> + c] =
        dof >= 0 && work.Has(c) ? solution[work.At(dof, c)] : 0.0;
  }
}

// sum += L21ᵀ·x of one block of eight pivots, over the staged border rows from `first` on.
template <int Tiles>
__device__ void AddBorderRows(const ManyWork& work, int first, int block, const double* staged,
                              double (&sum)[Tiles][4]) {
  const Lane lane = LaneOfWarp();
  constexpr int kStride = kStagedStride<Tiles>;
  const int pivots = work.front.pivots, rows = min(kStagedRows, work.front.border - first);
  const double* L21 =
      work.panel + static_cast<std::int64_t>(pivots + first + lane.t) * pivots + 8 * block + lane.g;
#pragma unroll 4
  for (int i = 0; i < rows; i += 8) {
    const double b[2] = {L21[i * pivots], L21[(i + 4) * pivots]};
    const double* x = staged + (i + lane.t) * kStride + lane.g;
#pragma unroll
    for (int tile = 0; tile < Tiles; ++tile) {
      const double* at = x + kColumnTile * tile;
      MultiplyAdd(sum[tile], {at[0], at[8], at[4 * kStride], at[4 * kStride + 8]}, b);
    }
  }
}

// Y = L21ᵀ·x; warp w has the block of pivots w.
template <int Tiles>
__device__ void BackwardBorder(const ManyWork& work, const double* solution, double* Y,
                               double* staged) {
  const Lane lane = LaneOfWarp();
  const int block = threadIdx.x >> 5;
  const bool acts = block < work.front.pivots / 8;
  double sum[Tiles][4] = {};
  for (int first = 0; first < work.front.border; first += kStagedRows) {
    StageBorder<Tiles>(work, first, solution, staged);
    __syncthreads();
    if (acts) AddBorderRows<Tiles>(work, first, block, staged, sum);
    __syncthreads();
  }
  if (!acts) return;
#pragma unroll
  for (int tile = 0; tile < Tiles; ++tile)
#pragma unroll
    for (int n = 0; n < 4; ++n)
      Y[(kColumnTile * tile + lane.g + 8 * (n / 2)) * work.stride() + 8 * block + 2 * lane.t +
        n % 2] = sum[tile][n];
}

// Y ← L11⁻ᵀ·Y for one tile by one warp, p = 8·Blocks.
template <int Blocks>
__device__ void BackwardPivots(const double* L11, double* Y) {
  const Lane lane = LaneOfWarp();
  constexpr int kPivots = 8 * Blocks, kStride = kPivots + 4;
  double sum[Blocks][4] = {};
#pragma unroll
  for (int block = Blocks - 1; block >= 0; --block) {
    const int c = 8 * block + 2 * lane.t;
    double *low = Y + lane.g * kStride + c, *high = low + 8 * kStride;
    const double* row = L11 + c * kStride + lane.g;  // of L, columns of this lane
    const double b[4] = {low[0] - sum[block][0], high[0] - sum[block][2], low[1] - sum[block][1],
                         high[1] - sum[block][3]};
    double y[4] = {};
    MultiplyAdd(y, b, {row[8 * block], row[kStride + 8 * block]});
    low[0] = y[0];
    low[1] = y[1];
    high[0] = y[2];
    high[1] = y[3];
    const double a[4] = {y[0], y[2], y[1], y[3]};
#pragma unroll
    for (int j = 0; j < block; ++j) MultiplyAdd(sum[j], a, {row[8 * j], row[kStride + 8 * j]});
  }
}

// The same for a number of blocks of pivots, at most Most, that is known at run time.
template <int Most>
__device__ void BackwardPivots(int blocks, const double* L11, double* Y) {
  if constexpr (Most > 1)
    if (blocks < Most) return BackwardPivots<Most - 1>(blocks, L11, Y);
  BackwardPivots<Most>(L11, Y);
}

template <int Tiles>
__global__ void __launch_bounds__(kThreads, 3)
    BackwardManyFronts(PlanView plan, int first, FactorPlace factor, double* solution,
                       SolutionSum total, int columns) {
  extern __shared__ __align__(16) double Y[];
  const std::int64_t slot = blockIdx.y, offset = slot * columns * plan.num_dofs;
  const Front front = plan.fronts[plan.level_front[first + blockIdx.x]];
  const ManyWork work{plan, front, factor.Of(plan, slot) + front.factor_offset, columns,
                      kColumnTile * Tiles * static_cast<int>(blockIdx.z)};
  const int stride = work.stride(), warp = threadIdx.x >> 5;
  solution += offset;
  // The staged rows' place is L11's afterwards.
  double* L11 = Y + kColumnTile * Tiles * stride;
  BackwardBorder<Tiles>(work, solution, Y, L11);
  LoadPivotBlock(work, L11);
  __syncthreads();
  ForEachPivot<Tiles>(work, [&](int r, int c) {
    double& y = Y[c * stride + r];
    const bool there = r < front.true_pivots && work.Has(c);
    y = (there ? solution[work.At(front.first_dof + r, c)] : 0.0) - y;
  });
  __syncthreads();
  if (warp < Tiles) BackwardPivots<8>(front.pivots / 8, L11, Y + kColumnTile * warp * stride);
  __syncthreads();
  ForEachPivot<Tiles>(work, [&](int r, int c) {
    if (r >= front.true_pivots || !work.Has(c)) return;
    const std::int64_t at = work.At(front.first_dof + r, c);
    solution[at] = Y[c * stride + r];
    if (total.sum != nullptr) total.sum[offset + at] += total.scale * Y[c * stride + r];
  });
}

// Tiles a block, evenly over as few blocks as hold them.
int TilesOfBlock(int columns) {
  const int tiles = (columns + kColumnTile - 1) / kColumnTile;
  const int blocks = (tiles + kMostTiles - 1) / kMostTiles;
  return (tiles + blocks - 1) / blocks;
}

// By the tiles of a block.
const auto kForward = {ForwardManyFronts<1>, ForwardManyFronts<2>, ForwardManyFronts<3>};
const auto kBackward = {BackwardManyFronts<1>, BackwardManyFronts<2>, BackwardManyFronts<3>};

// Launches the kernel for the tiles of `columns`, with shared memory for Y and for L11 or the
// staged rows.
template <class Kernel, class... Arguments>
void LaunchLevel(const LevelLaunch& on, std::initializer_list<Kernel*> kernels, int columns,
                 const Arguments&... arguments) {
  const int tiles = TilesOfBlock(columns), width = kColumnTile * tiles;
  const dim3 grid(on.level.end - on.level.begin, on.slots, (columns + width - 1) / width);
  const int pivots = on.level.largest_pivots, stride = pivots + 4;
  const int doubles = width * stride + std::max(pivots * stride, kStagedRows * (width + 8));
  Kernel* const kernel = kernels.begin()[tiles - 1];
  kernel<<<grid, kThreads, doubles * sizeof(double), on.stream>>>(on.plan, on.level.begin,
                                                                  arguments..., columns);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace

void PrepareSolveManyKernels(int shared_bytes) {
  for (auto* kernel : kForward) AllowSharedMemory(kernel, shared_bytes);
  for (auto* kernel : kBackward) AllowSharedMemory(kernel, shared_bytes);
}

void LaunchForwardManyLevel(const LevelLaunch& on, const FactorPlace& factor, const double* rhs,
                            double* solution, double* vectors, int columns) {
  LaunchLevel(on, kForward, columns, factor, rhs, solution, vectors);
}

void LaunchBackwardManyLevel(const LevelLaunch& on, const FactorPlace& factor, double* solution,
                             const SolutionSum& sum, int columns) {
  LaunchLevel(on, kBackward, columns, factor, solution, sum);
}

}  // namespace drape
