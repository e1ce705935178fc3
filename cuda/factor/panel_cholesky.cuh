// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cholesky factorisation of a panel in shared memory by a block of threads.

#include "cuda/factor/tensor_core.cuh"

namespace drape {

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

}  // namespace drape
