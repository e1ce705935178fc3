// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_error.h"
#include "cuda/factor/multifrontal_kernels.h"
#include "cuda/factor/tensor_core.cuh"

// Numerical factorisation of a batch: one block of threads for each (front, slot). The panel lives
// in shared memory, rows of p + 4 numbers (no bank conflicts), and stays there until it is done.

namespace drape {
namespace {

// Cholesky factorisation of a panel in shared memory by a block of threads.

// The present 8×8 block of a tile of 16 rows (or of `upper` 0: of the first eight of them) in the
// layout of MultiplyAdd's d.
struct ColumnTile {
  double2 low, high;
};

// Rows of block column `first` from `row` on: subtracts what the columns before contribute, and
// multiplies by the transposed inverse of the diagonal block.
__device__ __forceinline__ ColumnTile FinishTile(const double* panel, int stride, int first,
                                                 int row, int upper, double (&sum)[4]) {
  const Lane lane = LaneOfWarp();
  const double* at = panel + (row + lane.g) * stride + first + 2 * lane.t;
  const double2 u = *reinterpret_cast<const double2*>(at);
  const double2 v = *reinterpret_cast<const double2*>(at + upper * stride);
  const double2 inverse =
      *reinterpret_cast<const double2*>(panel + (first + lane.g) * stride + first + 2 * lane.t);
  const double a[4] = {u.x - sum[0], v.x - sum[2], u.y - sum[1], v.y - sum[3]};
  const double b[2] = {inverse.x, inverse.y};
  double product[4] = {};
  MultiplyAdd(product, a, b);
  return {{product[0], product[1]}, {product[2], product[3]}};
}

__device__ __forceinline__ void FactorTile(double* panel, int stride, int first, int row,
                                           int rows) {
  const Lane lane = LaneOfWarp();
  const int upper = row + 8 < rows ? 8 : 0;
  double sum[4] = {};
  for (int k = 0; k < first; k += 8) {
    double a[4], b[2];
    LoadA(a, panel + row * stride + k, stride, lane, upper);
    LoadTransposedB(b, panel + first * stride + k, stride, lane);
    MultiplyAdd(sum, a, b);
  }
  const ColumnTile tile = FinishTile(panel, stride, first, row, upper, sum);
  double* at = panel + (row + lane.g) * stride + first + 2 * lane.t;
  *reinterpret_cast<double2*>(at) = tile.low;
  if (upper != 0) *reinterpret_cast<double2*>(at + 8 * stride) = tile.high;
}

// The diagonal block at `first`, from which the columns before have been subtracted, becomes the
// inverse of its factor.
__device__ __forceinline__ bool InvertDiagonal(double* panel, int stride, int first,
                                               double2 block) {
  const Lane lane = LaneOfWarp();
  double2 inverse;
  const bool positive = InvertCholesky8(block.x, block.y, inverse.x, inverse.y, lane);
  *reinterpret_cast<double2*>(panel + (first + lane.g) * stride + first + 2 * lane.t) = inverse;
  return positive;
}

// The rows of the next diagonal block: their part of block column `first`, then that block.
__device__ __forceinline__ bool FactorNextPivots(double* panel, int stride, int first) {
  const Lane lane = LaneOfWarp();
  const int row = first + 8;
  double sum[4] = {}, diagonal[4] = {};
  for (int k = 0; k < first; k += 8) {
    double a[4], b[2];
    LoadA(a, panel + row * stride + k, stride, lane, 0);
    LoadTransposedB(b, panel + first * stride + k, stride, lane);
    const double own[2] = {a[0], a[2]};
    MultiplyAdd(sum, a, b);
    MultiplyAdd(diagonal, a, own);
  }
  const double2 low = FinishTile(panel, stride, first, row, 0, sum).low;
  double* at = panel + (row + lane.g) * stride + first + 2 * lane.t;
  *reinterpret_cast<double2*>(at) = low;
  const double a[4] = {low.x, low.x, low.y, low.y}, own[2] = {low.x, low.y};
  MultiplyAdd(diagonal, a, own);
  const double2 block = *reinterpret_cast<const double2*>(at + 8);
  return InvertDiagonal(panel, stride, row, {block.x - diagonal[0], block.y - diagonal[1]});
}

// Left-looking Cholesky of the panel by block columns of eight. Diagonal blocks become the inverses
// of their factors, so that each solve is a product too. While the first warp factors the next
// diagonal block, the others finish the present column.
__device__ __forceinline__ bool FactorPanel(double* panel, int pivots, int rows) {
  const int warp = threadIdx.x >> 5, warps = blockDim.x >> 5, stride = pivots + 4;
  bool positive = true;
  if (warp == 0) {
    const Lane lane = LaneOfWarp();
    positive = InvertDiagonal(
        panel, stride, 0, *reinterpret_cast<const double2*>(panel + lane.g * stride + 2 * lane.t));
  }
  __syncthreads();
  for (int first = 0; first < pivots; first += 8) {
    const bool last = first + 8 == pivots;
    if (warp == 0 && !last) {
      positive = FactorNextPivots(panel, stride, first) && positive;
    } else {
      const int begin = last ? first + 8 + 16 * warp : first + 16 * warp;
      for (int row = begin; row < rows; row += 16 * (last ? warps : warps - 1))
        FactorTile(panel, stride, first, row, rows);
    }
    __syncthreads();
  }
  return positive;
}

// Where a child's update lies and which of its rows a row of the front is.
struct ChildUpdate {
  const double* update;
  const std::int16_t* row;  // [p + q], −1 where the child has none
  int border;
};

constexpr int kStagedChildren = 6;

// A front of one slot. What a loop needs lies in registers and in shared memory: the compiler must
// read it again after each store otherwise.
struct FrontWork {
  const PlanView& plan;
  const Front front;
  const double* matrix;         // the slot's blocks
  double* update;               // the slot's updates
  const ChildUpdate* children;  // the first ones, in shared memory
  bool with_rhs;

  __device__ int rows() const { return front.pivots + front.border; }
  __device__ int stride() const { return front.pivots + 4; }
  __device__ int num_children() const { return front.child_end - front.child_start; }
  __device__ ChildUpdate child(int k) const {
    return k < kStagedChildren ? children[k] : FindChild(k);
  }
  __device__ ChildUpdate FindChild(int k) const {
    const FrontChild& child = plan.children[front.child_start + k];
    const Front& from = plan.fronts[child.front];
    return {update + from.update_offset, plan.child_row + child.row_start, from.border};
  }
  // All threads of a block call it and must meet before children are used.
  __device__ void StageChildren(ChildUpdate* staged) const {
    if (const int k = threadIdx.x; k < min(num_children(), kStagedChildren))
      staged[k] = FindChild(k);
  }
};

// A row of a 3×3 block of the matrix on its way to the panel.
struct EntryRow {
  double value[3];
  int place;  // −1: none
};

// Row i of the 3·(entry_end − entry_start) ones of the front.
__device__ EntryRow LoadEntryRow(const FrontWork& work, int i) {
  const Front& front = work.front;
  EntryRow row{{}, -1};
  if (i >= 3 * (front.entry_end - front.entry_start)) return row;
  const FrontEntry& entry = work.plan.entries[front.entry_start + i / 3];
  const double* from = work.matrix + 9LL * front.entry_start + 3 * i;
  for (int k = 0; k < 3; ++k) row.value[k] = from[k];
  row.place = (entry.panel_row + i % 3) * work.stride() + entry.panel_column;
  return row;
}

__device__ void AddEntryRow(const EntryRow& row, double* panel) {
  if (row.place < 0) return;
  for (int k = 0; k < 3; ++k) panel[row.place + k] += row.value[k];
}

// Sums children first … first + kCount over `kWide` halves of 32 columns of the panel, of which the
// lower triangle counts, and writes it there or, if they are not the first children, adds it. A
// warp has `kRows` rows at a time: their loads are in flight together.
template <int kWide, int kCount>
__device__ void GatherChildRows(const FrontWork& work, int first_child, double* panel) {
  constexpr int kRows = 24 / (kWide * kCount);
  const int lane = threadIdx.x & 31, warp = threadIdx.x >> 5, warps = blockDim.x >> 5;
  const int pivots = work.front.pivots, rows = work.rows(), stride = work.stride();
  const bool add = first_child > 0;
  const double* update[kCount];
  const std::int16_t* child_row[kCount];
  int border[kCount], column[kCount][kWide];
#pragma unroll
  for (int k = 0; k < kCount; ++k) {
    const ChildUpdate child = work.child(first_child + k);
    update[k] = child.update;
    child_row[k] = child.row;
    border[k] = child.border;
#pragma unroll
    for (int w = 0; w < kWide; ++w)
      column[k][w] = lane + 32 * w < pivots ? child.row[lane + 32 * w] : -1;
  }
  for (int first = kRows * warp; first < rows + (work.with_rhs ? 1 : 0); first += kRows * warps) {
    double value[kRows][kCount][kWide];
#pragma unroll
    for (int u = 0; u < kRows; ++u)
#pragma unroll
      for (int k = 0; k < kCount; ++k) {
        const int r = first + u;
        const int from = r < rows ? child_row[k][r] : r == rows && work.with_rhs ? border[k] : -1;
        const double* at = update[k] + static_cast<std::int64_t>(from) * border[k];
#pragma unroll
        for (int w = 0; w < kWide; ++w) {
          const int j = column[k][w];
          value[u][k][w] = from >= 0 && j >= 0 && j <= from ? at[j] : 0.0;
        }
      }
#pragma unroll
    for (int u = 0; u < kRows; ++u)
#pragma unroll
      for (int w = 0; w < kWide; ++w) {
        const int r = first + u, c = lane + 32 * w;
        if (r > rows || (r == rows && !work.with_rhs) || c >= pivots) continue;
        double sum = add ? panel[r * stride + c] : 0.0;
#pragma unroll
        for (int k = 0; k < kCount; ++k) sum += value[u][k][w];
        panel[r * stride + c] = sum;
      }
  }
}

template <int kWide>
__device__ void GatherPanel(const FrontWork& work, double* panel) {
  int child = 0;
  for (; child + 2 <= work.num_children(); child += 2)
    GatherChildRows<kWide, 2>(work, child, panel);
  if (child == work.num_children()) return;
  // The rows of one child lie with other warps than the rows of two.
  if (child > 0) __syncthreads();
  GatherChildRows<kWide, 1>(work, child, panel);
}

// Children's updates, then the matrix, which is loaded meanwhile. Row p + q is the right-hand
// side's, seven rows of zeros follow it.
template <int kThreads>
__device__ void AssemblePanel(const FrontWork& work, const double* rhs, double* panel) {
  constexpr int kAhead = 512 / kThreads;
  const Front& front = work.front;
  const int rows = work.rows(), stride = work.stride();
  EntryRow ahead[kAhead];
#pragma unroll
  for (int u = 0; u < kAhead; ++u) ahead[u] = LoadEntryRow(work, threadIdx.x + u * kThreads);
  const bool leaf = work.num_children() == 0;
  const int first_zero = leaf ? 0 : rows + 1, rows_with_rhs = work.with_rhs ? rows + 8 : rows;
  double2* pairs = reinterpret_cast<double2*>(panel);
  for (int i = first_zero * stride / 2 + threadIdx.x; i < rows_with_rhs * stride / 2; i += kThreads)
    pairs[i] = {0.0, 0.0};
  if (!leaf) {
    if (front.pivots <= 32) {
      GatherPanel<1>(work, panel);
    } else {
      GatherPanel<2>(work, panel);
    }
  }
  __syncthreads();
#pragma unroll
  for (int u = 0; u < kAhead; ++u) AddEntryRow(ahead[u], panel);
  for (int i = threadIdx.x + kAhead * kThreads; i < 3 * (front.entry_end - front.entry_start);
       i += kThreads)
    AddEntryRow(LoadEntryRow(work, i), panel);
  for (int r = front.true_pivots + threadIdx.x; r < front.pivots; r += kThreads)
    panel[r * stride + r] = 1.0;
  if (work.with_rhs)
    for (int r = threadIdx.x; r < front.true_pivots; r += kThreads)
      panel[rows * stride + r] += rhs[front.first_dof + r];
  __syncthreads();
}

constexpr int kTileColumns = 4;  // of eight numbers each
using TileSums = double[kTileColumns][4];

// Subtracts from the tile what children first … first + kCount contribute to the 16 × 32 numbers
// from (row0, column0) of a front's update. All loads are in flight together.
template <int kCount>
__device__ void SubtractChildren(const FrontWork& work, int first_child, int row0, int column0,
                                 TileSums& sums) {
  const Lane lane = LaneOfWarp();
  const int border = work.front.border, pivots = work.front.pivots;
  double value[kCount][kTileColumns][4];
#pragma unroll
  for (int k = 0; k < kCount; ++k) {
    const ChildUpdate child = work.child(first_child + k);
    const std::int16_t* child_row = child.row + pivots;
    const double* at[2];
    int last[2];  // column of the child's that is still in the lower triangle
#pragma unroll
    for (int half = 0; half < 2; ++half) {
      const int i = row0 + 8 * half + lane.g;
      last[half] = i < border ? child_row[i] : i == border && work.with_rhs ? child.border : -1;
      at[half] = child.update + static_cast<std::int64_t>(last[half]) * child.border;
    }
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) {
      const int j = column0 + 8 * n + 2 * lane.t;
      const short2 column =
          j < border ? *reinterpret_cast<const short2*>(child_row + j) : make_short2(-1, -1);
#pragma unroll
      for (int half = 0; half < 2; ++half) {
        value[k][n][2 * half] = column.x >= 0 && column.x <= last[half] ? at[half][column.x] : 0.0;
        value[k][n][2 * half + 1] =
            column.y >= 0 && column.y <= last[half] ? at[half][column.y] : 0.0;
      }
    }
  }
#pragma unroll
  for (int k = 0; k < kCount; ++k)
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n)
#pragma unroll
      for (int m = 0; m < 4; ++m) sums[n][m] -= value[k][n][m];
}

__device__ void SubtractAllChildren(const FrontWork& work, int row0, int column0, TileSums& sums) {
  int child = 0;
  for (; child + 2 <= work.num_children(); child += 2)
    SubtractChildren<2>(work, child, row0, column0, sums);
  if (child < work.num_children()) SubtractChildren<1>(work, child, row0, column0, sums);
}

// update = −sums, lower triangle and the right-hand side's row.
__device__ void StoreTile(const FrontWork& work, int row0, int column0, const TileSums& sums) {
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
            -sums[n][2 * half], -sums[n][2 * half + 1]};
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
    TileSums sums = {};
    SubtractAllChildren(work, row0, column0, sums);
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
        MultiplyAdd(sums[n], a, b);
      }
    }
    StoreTile(work, row0, column0, sums);
  }
}

// A warp has one row at a time, of narrow panels two.
__device__ void StorePanel(const Front& front, const double* panel, double* factor) {
  const int pivots = front.pivots, stride = pivots + 4, rows = pivots + front.border;
  const int narrow = pivots <= 32 ? 1 : 0;
  const int warp = threadIdx.x >> 5, lane = threadIdx.x & 31, warps = blockDim.x >> 5;
  const int row = narrow ? 2 * warp + (lane >> 4) : warp, column = 2 * (narrow ? lane & 15 : lane);
  if (column >= pivots) return;
  for (int r = row; r < rows; r += warps << narrow)
    *reinterpret_cast<double2*>(factor + static_cast<std::int64_t>(r) * pivots + column) =
        *reinterpret_cast<const double2*>(panel + r * stride + column);
}

// The right-hand side rides along as row p + q of the panel: it leaves as the forward solution.
template <int kThreads>
__global__ void __launch_bounds__(kThreads, 512 / kThreads)
    FactorFronts(PlanView plan, int first, FactorView view, const double* rhs, double* solution,
                 bool form_update) {
  extern __shared__ __align__(16) double panel[];
  __shared__ ChildUpdate children[kStagedChildren];
  const std::int64_t slot = blockIdx.y;
  const FrontWork work{plan,
                       plan.fronts[plan.level_front[first + blockIdx.x]],
                       view.matrix + slot * 9 * plan.num_entries,
                       view.update + slot * plan.update_size,
                       children,
                       rhs != nullptr};
  const Front& front = work.front;
  work.StageChildren(children);
  __syncthreads();
  const double* slot_rhs = rhs == nullptr ? nullptr : rhs + slot * plan.num_dofs;
  AssemblePanel<kThreads>(work, slot_rhs, panel);
  const bool positive =
      FactorPanel(panel, front.pivots, rhs != nullptr ? work.rows() + 8 : work.rows());
  if (!positive && threadIdx.x == 0) view.failed[slot] = 1;
  StorePanel(front, panel, view.factor.Of(plan, slot) + front.factor_offset);
  if (rhs != nullptr)
    for (int r = threadIdx.x; r < front.true_pivots; r += blockDim.x)
      solution[slot * plan.num_dofs + front.first_dof + r] = panel[work.rows() * work.stride() + r];
  if (form_update && front.border > 0) FormUpdate(work, panel);
}

// One 64 × 64 tile of an update, its two strips of L21 in shared memory.
__global__ void __launch_bounds__(256) FormUpdateTiles(PlanView plan, const UpdateTile* tiles,
                                                       FactorView view, const double* solution) {
  extern __shared__ __align__(16) double shared[];
  const std::int64_t slot = blockIdx.y;
  const UpdateTile tile = tiles[blockIdx.x];
  __shared__ ChildUpdate children[kStagedChildren];
  const FrontWork work{plan,        plan.fronts[tile.front],
                       view.matrix, view.update + slot * plan.update_size,
                       children,    solution != nullptr};
  const Front& front = work.front;
  work.StageChildren(children);
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
  TileSums sums = {};
  SubtractAllChildren(work, row0, column0, sums);
  for (int k = 0; k < pivots; k += 8) {
    double a[4];
    LoadA(a, rows + local_row * stride + k, stride, lane);
#pragma unroll
    for (int n = 0; n < kTileColumns; ++n) {
      double b[2];
      LoadTransposedB(b, columns + (local_column + 8 * n) * stride + k, stride, lane);
      MultiplyAdd(sums[n], a, b);
    }
  }
  StoreTile(work, row0, column0, sums);
}

}  // namespace

void PrepareFactorKernels(int shared_bytes) {
  AllowSharedMemory(FactorFronts<128>, shared_bytes);
  AllowSharedMemory(FactorFronts<256>, shared_bytes);
  AllowSharedMemory(FactorFronts<512>, shared_bytes);
  AllowSharedMemory(FormUpdateTiles, shared_bytes);
}

void LaunchFactorLevel(const LevelLaunch& on, const FactorView& view, const UpdateTile* tiles,
                       const double* rhs, double* solution, int threads) {
  const auto kernel = threads == 128   ? FactorFronts<128>
                      : threads == 256 ? FactorFronts<256>
                                       : FactorFronts<512>;
  kernel<<<dim3(on.level.end - on.level.begin, on.slots), threads, on.level.shared_panel,
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
