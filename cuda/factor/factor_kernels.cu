// SPDX-License-Identifier: Apache-2.0
// Numerical factorisation of a batch: one block of threads for each (front, slot). The panel lives
// in shared memory, rows of p + 4 numbers (no bank conflicts), and stays there until it is done.
#include "cuda/device/cuda_error.h"
#include "cuda/factor/multifrontal_kernels.h"
#include "cuda/factor/tensor_core.cuh"

namespace drape {
namespace {

constexpr int kBlockStride = 12;  // of the 8×8 inverse in shared memory
constexpr int kBlockDoubles = 96;

// A front of one slot.
struct FrontWork {
  const PlanView& plan;
  const Front& front;
  const double* matrix;  // the slot's blocks
  double* update;        // the slot's updates
  bool with_rhs;

  __device__ int rows() const { return front.pivots + front.border; }
  __device__ int stride() const { return front.pivots + 4; }
};

__device__ void ScatterEntries(const FrontWork& work, double* panel) {
  const Front& front = work.front;
  const double* from = work.matrix + 9LL * front.entry_start;
  const int count = 3 * (front.entry_end - front.entry_start), stride = work.stride();
  for (int i = threadIdx.x; i < count; i += blockDim.x) {
    const FrontEntry& entry = work.plan.entries[front.entry_start + i / 3];
    double* to = panel + (entry.panel_row + i % 3) * stride + entry.panel_column;
    for (int k = 0; k < 3; ++k) to[k] = from[3 * i + k];
  }
  for (int r = front.true_pivots + threadIdx.x; r < front.pivots; r += blockDim.x)
    panel[r * stride + r] = 1.0;
}

// Adds `kWide` halves of 32 columns of a child's update to the panel, `kRows` rows of it at a time:
// their loads are in flight together.
template <int kWide, int kRows>
__device__ void AddChildRows(const FrontWork& work, const FrontChild& child, double* panel) {
  const int lane = threadIdx.x & 31, warp = threadIdx.x >> 5, warps = blockDim.x >> 5;
  const Front& from = work.plan.fronts[child.front];
  const double* update = work.update + from.update_offset;
  const std::int16_t* parent_row = work.plan.parent_row + child.row_start;
  const int stride = work.stride(), columns = child.pivot_rows, border = from.true_border;
  const int rows = border + (work.with_rhs ? 1 : 0);
  int to_column[kWide];
  for (int k = 0; k < kWide; ++k)
    to_column[k] = lane + 32 * k < columns ? parent_row[lane + 32 * k] : 0;
  for (int first = kRows * warp; first < rows; first += kRows * warps) {
    double value[kRows][kWide];
    int to_row[kRows];
#pragma unroll
    for (int u = 0; u < kRows; ++u) {
      const int r = first + u, row = r < border ? r : from.border;  // the last is the rhs's
      to_row[u] = r < border ? parent_row[r] * stride : work.rows() * stride;
#pragma unroll
      for (int k = 0; k < kWide; ++k) {
        const int c = lane + 32 * k;
        value[u][k] = r < rows && c < columns && c <= r ? update[row * from.border + c] : 0.0;
      }
    }
#pragma unroll
    for (int u = 0; u < kRows; ++u)
#pragma unroll
      for (int k = 0; k < kWide; ++k) {
        const int r = first + u, c = lane + 32 * k;
        if (r < rows && c < columns && c <= r) panel[to_row[u] + to_column[k]] += value[u][k];
      }
  }
}

__device__ void AssemblePanel(const FrontWork& work, double* panel) {
  for (int i = threadIdx.x; i < work.rows() * work.stride(); i += blockDim.x) panel[i] = 0.0;
  __syncthreads();
  ScatterEntries(work, panel);
  __syncthreads();
  for (int c = work.front.child_start; c < work.front.child_end; ++c) {
    const FrontChild& child = work.plan.children[c];
    if (child.pivot_rows <= 32) {
      AddChildRows<1, 8>(work, child, panel);
    } else {
      AddChildRows<2, 4>(work, child, panel);
    }
    __syncthreads();
  }
}

// One tile of 16 rows of block column `first`: subtracts what the columns before contribute. The
// first tile's diagonal block is factored at once.
__device__ void UpdateTileOfColumn(double* panel, int stride, int first, int tile, int rows,
                                   double* inverse, bool& positive) {
  const Lane lane = LaneOfWarp();
  double* at = panel + (first + 16 * tile) * stride;
  const int upper = first + 16 * tile + 8 < rows ? 8 : 0;
  double sum[4] = {};
  for (int k = 0; k < first; k += 8) {
    double a[4], b[2];
    LoadA(a, at + k, stride, lane, upper);
    LoadTransposedB(b, panel + first * stride + k, stride, lane);
    MultiplyAdd(sum, a, b);
  }
  double2& low = *reinterpret_cast<double2*>(at + lane.g * stride + first + 2 * lane.t);
  double2& high = *reinterpret_cast<double2*>(at + (lane.g + upper) * stride + first + 2 * lane.t);
  double2 u = low, v = high;
  u.x -= sum[0];
  u.y -= sum[1];
  if (tile == 0) {
    double e0, e1;
    positive = InvertCholesky8(u.x, u.y, e0, e1, lane) && positive;
    inverse[lane.g * kBlockStride + 2 * lane.t] = e0;
    inverse[lane.g * kBlockStride + 2 * lane.t + 1] = e1;
  }
  low = u;
  if (upper != 0) high = {v.x - sum[2], v.y - sum[3]};
}

// Multiplies a tile by the transposed inverse of the diagonal block, which replaces that block.
__device__ void ScaleTileOfColumn(double* panel, int stride, int first, int tile, int rows,
                                  const double* inverse) {
  const Lane lane = LaneOfWarp();
  const double b[2] = {inverse[lane.g * kBlockStride + 2 * lane.t],
                       inverse[lane.g * kBlockStride + 2 * lane.t + 1]};
  double* at = panel + (first + 16 * tile) * stride + first;
  const int upper = first + 16 * tile + 8 < rows ? 8 : 0;
  double2& low = *reinterpret_cast<double2*>(at + lane.g * stride + 2 * lane.t);
  double2& high = *reinterpret_cast<double2*>(at + (lane.g + upper) * stride + 2 * lane.t);
  const double2 u = low, v = high;
  const double a[4] = {u.x, v.x, u.y, v.y};
  double product[4] = {};
  MultiplyAdd(product, a, b);
  low = tile == 0 ? double2{b[0], b[1]} : double2{product[0], product[1]};
  if (upper != 0) high = {product[2], product[3]};
}

// Left-looking Cholesky of the panel by block columns of eight. Diagonal blocks become the inverses
// of their factors, so that each solve is a product too.
__device__ bool FactorPanel(double* panel, int pivots, int rows, double* inverse) {
  const int warp = threadIdx.x >> 5, warps = blockDim.x >> 5, stride = pivots + 4;
  bool positive = true;
  for (int first = 0; first < pivots; first += 8) {
    const int tiles = (rows - first + 15) / 16;
    // The first warp has the first tile, the others share the rest.
    for (int tile = warp; tile < tiles; tile += tile == 0 ? tiles : warps - 1)
      UpdateTileOfColumn(panel, stride, first, tile, rows, inverse, positive);
    __syncthreads();
    for (int tile = warp; tile < tiles; tile += warps)
      ScaleTileOfColumn(panel, stride, first, tile, rows, inverse);
    __syncthreads();
  }
  return positive;
}

constexpr int kTileColumns = 4;  // of eight numbers each
using TileSums = double[kTileColumns][4];
using TileChildren = double[2][kTileColumns][2];

// What the children contribute to the 16 × 32 tile (row0, column0) of a front's update.
__device__ void GatherChildren(const FrontWork& work, int row0, int column0, TileChildren& sum) {
  const Lane lane = LaneOfWarp();
  const int border = work.front.border, pivots = work.front.pivots;
#pragma unroll
  for (int half = 0; half < 2; ++half)
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) sum[half][n][0] = sum[half][n][1] = 0.0;
  for (int k = work.front.child_start; k < work.front.child_end; ++k) {
    const FrontChild& child = work.plan.children[k];
    const Front& from = work.plan.fronts[child.front];
    const std::int16_t* child_row = work.plan.child_row + child.inverse_start + pivots;
    const double* update = work.update + from.update_offset;
    short2 column[kTileColumns];
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) {
      const int j = column0 + 8 * n + 2 * lane.t;
      column[n] =
          j < border ? *reinterpret_cast<const short2*>(child_row + j) : make_short2(-1, -1);
    }
#pragma unroll
    for (int half = 0; half < 2; ++half) {
      const int i = row0 + 8 * half + lane.g;
      const int row = i < border ? child_row[i] : i == border && work.with_rhs ? from.border : -1;
      if (row < 0) continue;
      const double* at = update + static_cast<std::int64_t>(row) * from.border;
#pragma unroll
      for (int n = 0; n < kTileColumns; ++n) {
        const int j = column0 + 8 * n + 2 * lane.t;
        if (column[n].x >= 0 && j <= i) sum[half][n][0] += at[column[n].x];
        if (column[n].y >= 0 && j < i) sum[half][n][1] += at[column[n].y];
      }
    }
  }
}

// update = children − products, lower triangle and the right-hand side's row.
__device__ void StoreTile(const FrontWork& work, int row0, int column0,
                          const TileChildren& children, const TileSums& products) {
  const Lane lane = LaneOfWarp();
  const int border = work.front.border, rows = border + (work.with_rhs ? 1 : 0);
  double* update = work.update + work.front.update_offset;
#pragma unroll
  for (int half = 0; half < 2; ++half)
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) {
      const int i = row0 + 8 * half + lane.g, j = column0 + 8 * n + 2 * lane.t;
      if (i < rows && j <= i && j < border)
        *reinterpret_cast<double2*>(update + static_cast<std::int64_t>(i) * border + j) = {
            children[half][n][0] - products[n][2 * half],
            children[half][n][1] - products[n][2 * half + 1]};
    }
}

// The update of a front whose panel is in shared memory: warps take 16 × 32 tiles of the lower
// triangle in turn.
__device__ void FormUpdate(const FrontWork& work, const double* panel) {
  const Lane lane = LaneOfWarp();
  const int pivots = work.front.pivots, border = work.front.border, stride = work.stride();
  const int last_row = border - 1 + (work.with_rhs ? 1 : 0), row_tiles = last_row / 16 + 1;
  const double* L21 = panel + pivots * stride;
  // Row tiles 2m and 2m + 1 have m + 1 column tiles each.
  const int pairs = (row_tiles - 1) / 2;
  const int tiles = pairs * (pairs + 1) + (row_tiles - 2 * pairs) * (pairs + 1);
  for (int x = threadIdx.x >> 5; x < tiles; x += blockDim.x >> 5) {
    int m = static_cast<int>((sqrtf(4.0f * x + 1.0f) - 1.0f) * 0.5f);
    while ((m + 1) * (m + 2) <= x) ++m;
    while (m * (m + 1) > x) --m;
    const int rest = x - m * (m + 1);
    const int row0 = 16 * (2 * m + rest / (m + 1)), column0 = 32 * (rest % (m + 1));
    TileChildren children;
    GatherChildren(work, row0, column0, children);
    TileSums products = {};
    const double* low = L21 + min(row0 + lane.g, last_row) * stride + lane.t;
    const double* high = L21 + min(row0 + 8 + lane.g, last_row) * stride + lane.t;
    const double* right[kTileColumns];
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n)
      right[n] = L21 + min(column0 + 8 * n + lane.g, border - 1) * stride + lane.t;
#pragma unroll 2
    for (int k = 0; k < pivots; k += 8) {
      const double a[4] = {low[k], high[k], low[k + 4], high[k + 4]};
#pragma unroll
      for (int n = 0; n < kTileColumns; ++n) {
        const double b[2] = {right[n][k], right[n][k + 4]};
        MultiplyAdd(products[n], a, b);
      }
    }
    StoreTile(work, row0, column0, children, products);
  }
}

__device__ void StorePanel(const Front& front, const double* panel, double* factor) {
  const int half = front.pivots / 2, stride = front.pivots + 4;
  for (int i = threadIdx.x; i < (front.pivots + front.border) * half; i += blockDim.x) {
    const int r = i / half, c = 2 * (i - r * half);
    *reinterpret_cast<double2*>(factor + static_cast<std::int64_t>(r) * front.pivots + c) =
        *reinterpret_cast<const double2*>(panel + r * stride + c);
  }
}

// The right-hand side rides along as row p + q of the panel: it leaves as the forward solution.
__global__ void __launch_bounds__(256, 2)
    FactorFronts(PlanView plan, int first, FactorView view, const double* rhs, double* solution,
                 bool form_update) {
  extern __shared__ __align__(16) double shared[];
  const std::int64_t slot = blockIdx.y;
  const Front& front = plan.fronts[plan.level_front[first + blockIdx.x]];
  const FrontWork work{plan, front, view.matrix + slot * 9 * plan.num_entries,
                       view.update + slot * plan.update_size, rhs != nullptr};
  double *inverse = shared, *panel = shared + kBlockDoubles;
  double* rhs_row = panel + work.rows() * work.stride();
  if (rhs != nullptr) {
    for (int i = threadIdx.x; i < 8 * work.stride(); i += blockDim.x) rhs_row[i] = 0.0;
    __syncthreads();
    for (int r = threadIdx.x; r < front.true_pivots; r += blockDim.x)
      rhs_row[r] = rhs[slot * plan.num_dofs + front.first_dof + r];
  }
  AssemblePanel(work, panel);
  const bool positive =
      FactorPanel(panel, front.pivots, rhs != nullptr ? work.rows() + 8 : work.rows(), inverse);
  if (!positive && threadIdx.x == 0) view.failed[slot] = 1;
  StorePanel(front, panel, view.factor.Of(plan, slot) + front.factor_offset);
  if (rhs != nullptr)
    for (int r = threadIdx.x; r < front.true_pivots; r += blockDim.x)
      solution[slot * plan.num_dofs + front.first_dof + r] = rhs_row[r];
  if (form_update && front.border > 0) FormUpdate(work, panel);
}

// One 64 × 64 tile of an update, its two strips of L21 in shared memory.
__global__ void __launch_bounds__(256) FormUpdateTiles(PlanView plan, const UpdateTile* tiles,
                                                       FactorView view, const double* solution) {
  extern __shared__ __align__(16) double shared[];
  const std::int64_t slot = blockIdx.y;
  const UpdateTile tile = tiles[blockIdx.x];
  const Front& front = plan.fronts[tile.front];
  const FrontWork work{plan, front, view.matrix, view.update + slot * plan.update_size,
                       solution != nullptr};
  const int pivots = front.pivots, border = front.border, stride = work.stride(), half = pivots / 2;
  const double* L21 =
      view.factor.Of(plan, slot) + front.factor_offset + static_cast<std::int64_t>(pivots) * pivots;
  const bool diagonal = tile.row == tile.column;
  double *rows = shared, *columns = diagonal ? shared : shared + kUpdateTile * stride;
  for (int i = threadIdx.x; i < kUpdateTile * half; i += blockDim.x) {
    const int r = i / half, c = 2 * (i - r * half), row = kUpdateTile * tile.row + r;
    double2 value;
    if (row == border && work.with_rhs) {
      const double* y = solution + slot * plan.num_dofs + front.first_dof;
      value = {c < front.true_pivots ? y[c] : 0.0, c + 1 < front.true_pivots ? y[c + 1] : 0.0};
    } else {
      value = *reinterpret_cast<const double2*>(
          L21 + static_cast<std::int64_t>(min(row, border - 1)) * pivots + c);
    }
    *reinterpret_cast<double2*>(rows + r * stride + c) = value;
    if (diagonal) continue;
    const int column = min(kUpdateTile * tile.column + r, border - 1);
    *reinterpret_cast<double2*>(columns + r * stride + c) =
        *reinterpret_cast<const double2*>(L21 + static_cast<std::int64_t>(column) * pivots + c);
  }
  __syncthreads();
  const Lane lane = LaneOfWarp();
  const int warp = threadIdx.x >> 5, local_row = 16 * (warp >> 1), local_column = 32 * (warp & 1);
  const int row0 = kUpdateTile * tile.row + local_row;
  const int column0 = kUpdateTile * tile.column + local_column;
  if (column0 > row0 + 15 || row0 >= border + (work.with_rhs ? 1 : 0) || column0 >= border) return;
  TileChildren children;
  GatherChildren(work, row0, column0, children);
  TileSums products = {};
  for (int k = 0; k < pivots; k += 8) {
    double a[4];
    LoadA(a, rows + local_row * stride + k, stride, lane);
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) {
      double b[2];
      LoadTransposedB(b, columns + (local_column + 8 * n) * stride + k, stride, lane);
      MultiplyAdd(products[n], a, b);
    }
  }
  StoreTile(work, row0, column0, children, products);
}

}  // namespace

void PrepareFactorKernels(int shared_bytes) {
  AllowSharedMemory(FactorFronts, shared_bytes);
  AllowSharedMemory(FormUpdateTiles, shared_bytes);
}

void LaunchFactorLevel(const LevelLaunch& on, const FactorView& view, const UpdateTile* tiles,
                       const double* rhs, double* solution, int threads) {
  FactorFronts<<<dim3(on.level.end - on.level.begin, on.slots), threads, on.level.shared_panel,
                 on.stream>>>(on.plan, on.level.begin, view, rhs, solution, tiles == nullptr);
  CUDA_CHECK(cudaGetLastError());
  const int count = on.level.tile_end - on.level.tile_begin;
  if (tiles == nullptr || count == 0) return;
  const int shared =
      2 * kUpdateTile * (on.level.largest_pivots + 4) * static_cast<int>(sizeof(double));
  FormUpdateTiles<<<dim3(count, on.slots), 256, shared, on.stream>>>(
      on.plan, tiles + on.level.tile_begin, view, rhs == nullptr ? nullptr : solution);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
