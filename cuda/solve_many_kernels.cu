// SPDX-License-Identifier: Apache-2.0
// Triangular solves with stored factors for many right-hand sides, in tiles of sixteen: products on
// the tensor cores, the front's panel in shared memory, one warp a tile.
#include <algorithm>

#include "cuda/cuda_error.h"
#include "cuda/multifrontal_kernels.h"
#include "cuda/tensor_core.cuh"

namespace drape {
namespace {

constexpr int kColumnTile = 16;
constexpr int kMostTiles = 5;  // a block, of right-hand sides

// A front of one slot.
struct ManyWork {
  const PlanView& plan;
  const Front& front;
  const double* panel;  // in shared memory, rows of p + 4
  int columns;          // right-hand sides of the slot

  __device__ int stride() const { return front.pivots + 4; }
};

// Right-hand sides r and r + 8 of a tile at dofs c, c + 1 of the pivots, where there are such.
struct PivotPairs {
  double* at;  // right-hand side r at the front's first pivot
  int columns, true_pivots;
  bool low, high;  // r, r + 8 < columns

  __device__ PivotPairs(const ManyWork& work, double* solution, int r)
      : at(solution + static_cast<std::int64_t>(work.front.first_dof) * work.columns + r),
        columns(work.columns), true_pivots(work.front.true_pivots),
        low(r < work.columns), high(r + 8 < work.columns) {}
  // In the layout of a product: (low c, low c + 1, high c, high c + 1).
  __device__ void Load(int c, double (&v)[4]) const {
    const double *first = at + c * columns, *second = first + columns;
    v[0] = low && c < true_pivots ? first[0] : 0.0;
    v[1] = low && c + 1 < true_pivots ? second[0] : 0.0;
    v[2] = high && c < true_pivots ? first[8] : 0.0;
    v[3] = high && c + 1 < true_pivots ? second[8] : 0.0;
  }
  __device__ void Store(int c, const double (&v)[4]) const {
    double *first = at + c * columns, *second = first + columns;
    if (low && c < true_pivots) first[0] = v[0];
    if (low && c + 1 < true_pivots) second[0] = v[1];
    if (high && c < true_pivots) first[8] = v[2];
    if (high && c + 1 < true_pivots) second[8] = v[3];
  }
};

// Adds the children's vectors at rows r, r + 1 of the front for columns `column` and column + 8.
__device__ void AddChildren(const ManyWork& work, const double* vectors, int r, int column,
                            double (&v)[4]) {
  const bool low = column < work.columns, high = column + 8 < work.columns;
  for (int k = work.front.child_start; k < work.front.child_end; ++k) {
    const FrontChild& child = work.plan.children[k];
    const short2 row =
        *reinterpret_cast<const short2*>(work.plan.child_row + child.inverse_start + r);
    const int offset = work.plan.fronts[child.front].vector_offset;
    if (row.x >= 0) {
      const double* at = vectors + static_cast<std::int64_t>(offset + row.x) * work.columns + column;
      if (low) v[0] += at[0];
      if (high) v[2] += at[8];
    }
    if (row.y >= 0) {
      const double* at = vectors + static_cast<std::int64_t>(offset + row.y) * work.columns + column;
      if (low) v[1] += at[0];
      if (high) v[3] += at[8];
    }
  }
}

// y = (b − sum)·w, w the fragment of a diagonal block's inverse.
__device__ void SolveDiagonal(const double (&b)[4], const double (&sum)[4], const double (&w)[2],
                              double (&y)[4]) {
  const double a[4] = {b[0] - sum[0], b[2] - sum[2], b[1] - sum[1], b[3] - sum[3]};
  y[0] = y[1] = y[2] = y[3] = 0.0;
  MultiplyAdd(y, a, w);
}

__device__ void LoadPanel(const Front& front, const double* factor, double* panel) {
  const int half = front.pivots / 2, stride = front.pivots + 4;
  for (int i = threadIdx.x; i < (front.pivots + front.border) * half; i += blockDim.x) {
    const int r = i / half, c = 2 * (i - r * half);
    *reinterpret_cast<double2*>(panel + r * stride + c) =
        *reinterpret_cast<const double2*>(factor + static_cast<std::int64_t>(r) * front.pivots + c);
  }
}

// Pivots of the tile at `column` (this lane's): Y [16, p + 4] in shared memory and in the solution.
__device__ void ForwardPivots(const ManyWork& work, const double* rhs, const double* vectors,
                              int column, double* solution, double* Y) {
  const Lane lane = LaneOfWarp();
  const int stride = work.stride();
  const PivotPairs from(work, const_cast<double*>(rhs), column), to(work, solution, column);
  for (int first = 0; first < work.front.pivots; first += 8) {
    double sum[4] = {};
    for (int k = 0; k < first; k += 8) {
      double a[4], b[2];
      LoadA(a, Y + k, stride, lane);
      LoadTransposedB(b, work.panel + first * stride + k, stride, lane);
      MultiplyAdd(sum, a, b);
    }
    const int c = first + 2 * lane.t;
    double b[4], y[4];
    from.Load(c, b);
    AddChildren(work, vectors, c, column, b);
    const double* block = work.panel + (first + lane.g) * stride + c;
    SolveDiagonal(b, sum, {block[0], block[1]}, y);
    Y[lane.g * stride + c] = y[0];
    Y[lane.g * stride + c + 1] = y[1];
    Y[(lane.g + 8) * stride + c] = y[2];
    Y[(lane.g + 8) * stride + c + 1] = y[3];
    to.Store(c, y);
    __syncwarp();
  }
}

// Border rows c, c + 1 … of eight for the tile at `column`: children − L21·Y.
__device__ void ForwardBorder(const ManyWork& work, int first, int column, const double* Y,
                              double* vectors) {
  const Lane lane = LaneOfWarp();
  const int stride = work.stride(), c = first + 2 * lane.t;
  double value[4] = {}, product[4] = {};
  AddChildren(work, vectors, work.front.pivots + c, column, value);
  for (int k = 0; k < work.front.pivots; k += 8) {
    double a[4], b[2];
    LoadA(a, Y + k, stride, lane);
    LoadTransposedB(b, work.panel + (work.front.pivots + first) * stride + k, stride, lane);
    MultiplyAdd(product, a, b);
  }
  double* to = vectors +
               static_cast<std::int64_t>(work.front.vector_offset + c) * work.columns + column;
  if (column < work.columns) {
    to[0] = value[0] - product[0];
    to[work.columns] = value[1] - product[1];
  }
  if (column + 8 < work.columns) {
    to[8] = value[2] - product[2];
    to[work.columns + 8] = value[3] - product[3];
  }
}

// grid: fronts, slots, chunks of `tiles` tiles of right-hand sides.
__global__ void __launch_bounds__(256)
    ForwardManyFronts(PlanView plan, int first, const double* factor, const double* rhs,
                      double* solution, double* vectors, int columns, int tiles) {
  extern __shared__ __align__(16) double shared[];
  const std::int64_t slot = blockIdx.y, offset = slot * columns * plan.num_dofs;
  const Front& front = plan.fronts[plan.level_front[first + blockIdx.x]];
  const ManyWork work{plan, front, shared, columns};
  LoadPanel(front, factor + slot * plan.factor_size + front.factor_offset, shared);
  __syncthreads();
  vectors += slot * columns * plan.vector_size;
  const Lane lane = LaneOfWarp();
  const int warp = threadIdx.x >> 5, warps = blockDim.x >> 5, tile_doubles = 16 * work.stride();
  const int first_column = kColumnTile * tiles * static_cast<int>(blockIdx.z);
  double* Y = shared + (front.pivots + front.border) * work.stride();
  for (int tile = warp; tile < tiles; tile += warps)
    if (first_column + kColumnTile * tile < columns)
      ForwardPivots(work, rhs + offset, vectors, first_column + kColumnTile * tile + lane.g,
                    solution + offset, Y + tile * tile_doubles);
  __syncthreads();
  for (int i = warp; i < tiles * front.border / 8; i += warps) {
    const int tile = i / (front.border / 8), row = 8 * (i - tile * (front.border / 8));
    if (first_column + kColumnTile * tile < columns)
      ForwardBorder(work, row, first_column + kColumnTile * tile + lane.g,
                    Y + tile * tile_doubles, vectors);
  }
}

// One tile of sixteen right-hand sides, p = 8·Blocks: sums of all pivots stay in registers.
template <int Blocks>
__device__ void BackwardTile(const ManyWork& work, double* solution, const SolutionSum& total,
                             int column) {
  const Lane lane = LaneOfWarp();
  const int pivots = 8 * Blocks, stride = pivots + 4;
  const int* border_dof = work.plan.border_dof + work.front.border_start;
  const bool low = column < work.columns, high = column + 8 < work.columns;
  double sum[Blocks][4] = {};
  for (int i = 0; i < work.front.border; i += 8) {
    const int dof0 = border_dof[i + lane.t], dof1 = border_dof[i + lane.t + 4];
    const double* at0 = solution + static_cast<std::int64_t>(dof0) * work.columns + column;
    const double* at1 = solution + static_cast<std::int64_t>(dof1) * work.columns + column;
    const double a[4] = {low && dof0 >= 0 ? at0[0] : 0.0, high && dof0 >= 0 ? at0[8] : 0.0,
                         low && dof1 >= 0 ? at1[0] : 0.0, high && dof1 >= 0 ? at1[8] : 0.0};
    const double* L21 = work.panel + (pivots + i + lane.t) * stride + lane.g;
#pragma unroll
    for (int j = 0; j < Blocks; ++j) {
      const double b[2] = {L21[8 * j], L21[4 * stride + 8 * j]};
      MultiplyAdd(sum[j], a, b);
    }
  }
  const PivotPairs pairs(work, solution, column);
#pragma unroll
  for (int block = Blocks - 1; block >= 0; --block) {
    const int c = 8 * block + 2 * lane.t;
    double b[4], y[4];
    pairs.Load(c, b);
    const double* W = work.panel + c * stride + 8 * block + lane.g;
    SolveDiagonal(b, sum[block], {W[0], W[stride]}, y);
    pairs.Store(c, y);
    if (total.sum != nullptr) {
      const PivotPairs sums(work, total.sum, column);
      double so_far[4];
      sums.Load(c, so_far);
#pragma unroll
      for (int k = 0; k < 4; ++k) so_far[k] += total.scale * y[k];
      sums.Store(c, so_far);
    }
    const double a[4] = {y[0], y[2], y[1], y[3]};
#pragma unroll
    for (int j = 0; j < block; ++j) {
      const double right[2] = {work.panel[c * stride + 8 * j + lane.g],
                               work.panel[(c + 1) * stride + 8 * j + lane.g]};
      MultiplyAdd(sum[j], a, right);
    }
  }
}

__global__ void __launch_bounds__(32 * kMostTiles)
    BackwardManyFronts(PlanView plan, int first, const double* factor, double* solution,
                       SolutionSum total, int columns) {
  extern __shared__ __align__(16) double shared[];
  const std::int64_t slot = blockIdx.y;
  const Front& front = plan.fronts[plan.level_front[first + blockIdx.x]];
  const ManyWork work{plan, front, shared, columns};
  LoadPanel(front, factor + slot * plan.factor_size + front.factor_offset, shared);
  __syncthreads();
  solution += slot * columns * plan.num_dofs;
  if (total.sum != nullptr) total.sum += slot * columns * plan.num_dofs;
  const int warps = blockDim.x >> 5;
  const int tile = static_cast<int>(blockIdx.z) * warps + (threadIdx.x >> 5);
  if (kColumnTile * tile >= columns) return;
  const int column = kColumnTile * tile + LaneOfWarp().g;
  switch (front.pivots / 8) {
    case 1: return BackwardTile<1>(work, solution, total, column);
    case 2: return BackwardTile<2>(work, solution, total, column);
    case 3: return BackwardTile<3>(work, solution, total, column);
    case 4: return BackwardTile<4>(work, solution, total, column);
    case 5: return BackwardTile<5>(work, solution, total, column);
    case 6: return BackwardTile<6>(work, solution, total, column);
    case 7: return BackwardTile<7>(work, solution, total, column);
    default: return BackwardTile<8>(work, solution, total, column);
  }
}

// Evenly over as few blocks as hold them.
int TilesOfBlock(int columns, int most) {
  const int tiles = (columns + kColumnTile - 1) / kColumnTile, blocks = (tiles + most - 1) / most;
  return (tiles + blocks - 1) / blocks;
}
int BlocksOf(int columns, int tiles_of_block) {
  return (columns + kColumnTile * tiles_of_block - 1) / (kColumnTile * tiles_of_block);
}

}  // namespace

void PrepareSolveManyKernels(int shared_bytes) {
  AllowSharedMemory(ForwardManyFronts, shared_bytes);
  AllowSharedMemory(BackwardManyFronts, shared_bytes);
}

void LaunchForwardManyLevel(const PlanView& plan, const LevelRange& level, const double* factor,
                            const double* rhs, double* solution, double* vectors, int columns,
                            int slots, int shared_bytes, cudaStream_t stream) {
  const int tile_bytes = 16 * (level.largest_pivots + 4) * static_cast<int>(sizeof(double));
  const int fitting = (shared_bytes - level.shared_factor) / tile_bytes;
  const int tiles = TilesOfBlock(columns, std::clamp(fitting, 1, kMostTiles));
  const dim3 grid(level.end - level.begin, slots, BlocksOf(columns, tiles));
  ForwardManyFronts<<<grid, 256, level.shared_factor + tiles * tile_bytes, stream>>>(
      plan, level.begin, factor, rhs, solution, vectors, columns, tiles);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchBackwardManyLevel(const PlanView& plan, const LevelRange& level, const double* factor,
                             double* solution, const SolutionSum& sum, int columns, int slots,
                             cudaStream_t stream) {
  const int tiles = TilesOfBlock(columns, kMostTiles);
  const dim3 grid(level.end - level.begin, slots, BlocksOf(columns, tiles));
  BackwardManyFronts<<<grid, 32 * tiles, level.shared_factor, stream>>>(plan, level.begin, factor,
                                                                         solution, sum, columns);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
