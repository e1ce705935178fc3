// SPDX-License-Identifier: Apache-2.0
// The kernels for one vector width, in a file that is compiled for it: everything here is local to
// that file, so that no other uses its instructions. It must not call inline functions of other
// headers that a compiler may leave as functions.
#pragma once

#include "physics/linalg/kernels/front_kernels.h"
#include "physics/util/math/simd.h"

namespace drape {
namespace {

// Columns and registers of rows of a tile, whose sums fill the vector registers of the machine: 12
// of 16 of four doubles, 24 of 32 of eight.
template <class T>
constexpr int kTileColumns = kLanes<T>;
constexpr int kTileRegisters = 3;
constexpr int kDepth = 64;  // columns that stay in the cache while their products are summed

// sum −= a·b, rounded once where the machine can. Registers of a vector type are multiplied and
// subtracted by one instruction; where a compiler itself makes vectors of single numbers, it may
// round their products first.
template <class T>
inline __attribute__((always_inline)) void MultiplySubtract(const T& a, double b, T& sum) {
  sum -= a * b;
}
#ifdef __FP_FAST_FMA
template <>
inline __attribute__((always_inline)) void MultiplySubtract(const double& a, double b,
                                                            double& sum) {
  sum = __builtin_fma(-a, b, sum);
}
#endif

// V registers of rows × N columns of a column-major matrix.
template <class T, int V, int N>
struct PanelTile {
  T value[N][V];

  inline __attribute__((always_inline)) void Load(const double* from, std::ptrdiff_t stride) {
    for (int n = 0; n < N; ++n)
      for (int v = 0; v < V; ++v) value[n][v] = LoadAs<T>(from + n * stride + kLanes<T> * v);
  }
  inline __attribute__((always_inline)) void Save(double* to, std::ptrdiff_t stride) const {
    for (int n = 0; n < N; ++n)
      for (int v = 0; v < V; ++v) Store(value[n][v], to + n * stride + kLanes<T> * v);
  }
  // Subtracts A·Bᵀ, where A and B are rows of one panel, from `a` and `b` on, with `depth` columns.
  inline __attribute__((always_inline)) void Subtract(const double* a, const double* b,
                                                      std::ptrdiff_t stride, int depth) {
    for (int k = 0; k < depth; ++k, a += stride, b += stride) {
      T rows[V];
      for (int v = 0; v < V; ++v) rows[v] = LoadAs<T>(a + kLanes<T> * v);
      for (int n = 0; n < N; ++n)
        for (int v = 0; v < V; ++v) MultiplySubtract(rows[v], b[n], value[n][v]);
    }
  }
  // Multiplies by the inverse transpose of a lower triangle, whose diagonal is inverted already.
  inline __attribute__((always_inline)) void Solve(const double (&triangle)[N][N]) {
    for (int n = 0; n < N; ++n)
      for (int v = 0; v < V; ++v) {
        for (int k = 0; k < n; ++k) MultiplySubtract(value[k][v], triangle[n][k], value[n][v]);
        value[n][v] *= triangle[n][n];
      }
  }
};

// Subtracts A·Bᵀ from `rows` rows of N columns at `to`, or from zero.
template <class T, int N, bool kFromZero>
void SubtractRows(const double* a, const double* b, std::ptrdiff_t stride, int depth, int rows,
                  double* to, std::ptrdiff_t to_stride) {
  ForEachChunk<kTileRegisters>(rows / kLanes<T>, [&]<int V>(int v) {
    PanelTile<T, V, N> tile;
    if constexpr (kFromZero)
      tile = {};
    else
      tile.Load(to + kLanes<T> * v, to_stride);
    tile.Subtract(a + kLanes<T> * v, b, stride, depth);
    tile.Save(to + kLanes<T> * v, to_stride);
  });
}

// Factors columns j … j + N of a panel, of whose earlier columns those before `done` are
// subtracted.
template <class T, int N>
bool FactorColumns(const FrontPanel& panel, int done, int j) {
  const double* earlier = panel.column(done) + j;
  double* own = panel.column(j) + j;
  const std::ptrdiff_t stride = panel.stride;
  SubtractRows<T, N, false>(earlier, earlier, stride, j - done, kLanes<T>, own, stride);
  double triangle[N][N];
  for (int n = 0; n < N; ++n) {
    double* column = own + n * stride;
    for (int m = n; m < N; ++m)
      for (int k = 0; k < n; ++k) MultiplySubtract(triangle[m][k], triangle[n][k], column[m]);
    if (!(column[n] > 0.0)) return false;
    column[n] = __builtin_sqrt(column[n]);
    const double inverse = 1.0 / column[n];
    for (int m = n + 1; m < N; ++m) triangle[m][n] = column[m] *= inverse;
    triangle[n][n] = column[n];
  }
  for (int n = 0; n < N; ++n) triangle[n][n] = 1.0 / triangle[n][n];
  for (int i = N; i < kLanes<T>; ++i) {
    PanelTile<double, 1, N> row;
    row.Load(own + i, stride);
    row.Solve(triangle);
    row.Save(own + i, stride);
  }
  ForEachChunk<kTileRegisters>((panel.stride - j) / kLanes<T> - 1, [&]<int V>(int v) {
    const int i = kLanes<T> * (v + 1);
    PanelTile<T, V, N> tile;
    tile.Load(own + i, stride);
    tile.Subtract(earlier + i, earlier, stride, j - done);
    tile.Solve(triangle);
    tile.Save(own + i, stride);
  });
  return true;
}

template <class T>
bool FactorRange(const FrontPanel& panel, int begin, int end) {
  bool positive = true;
  ForEachChunk<kTileColumns<T>>(end - begin, [&]<int N>(int j) {
    positive = positive && FactorColumns<T, N>(panel, begin, begin + j);
  });
  return positive;
}

template <class T>
void SubtractColumns(const FrontPanel& panel, int begin, int end, int first, int last) {
  ForEachChunk<kTileColumns<T>>(last - first, [&]<int N>(int n) {
    const int j = first + n;
    const double* earlier = panel.column(begin) + j;
    SubtractRows<T, N, false>(earlier, earlier, panel.stride, end - begin, panel.stride - j,
                              panel.column(j) + j, panel.stride);
  });
}

template <class T>
void MultiplyBelow(const FrontPanel& panel, const UpdateMatrix& product, int begin, int end) {
  const int size = product.size;
  for (int depth = 0; depth == 0 || depth < panel.width; depth += kDepth) {
    const int columns = panel.width - depth < kDepth ? panel.width - depth : kDepth;
    ForEachChunk<kTileColumns<T>>(end - begin, [&]<int N>(int n) {
      const int j = begin + n, rows = UpdateMatrix::Padded(size) - j;
      const double* below = panel.column(depth) + panel.width + j;
      double* to = product.column(j) + j;
      if (depth == 0)
        SubtractRows<T, N, true>(below, below, panel.stride, columns, rows, to, product.stride(j));
      else
        SubtractRows<T, N, false>(below, below, panel.stride, columns, rows, to, product.stride(j));
    });
  }
}

template <class T, int kNumbers = kLanes<T>>
inline __attribute__((always_inline)) void AddRegister(const double*& from, double*& sum) {
  Store(LoadAs<T>(sum) + LoadAs<T>(from), sum);
  from += kNumbers;
  sum += kNumbers;
}

// Masks would be slower: a load beside a masked store waits for it.
template <class T>
inline __attribute__((always_inline)) void AddNumbers(const double* from, int count, double* sum) {
  using Vec2 = double __attribute__((vector_size(16)));
  constexpr int kWidth = kLanes<T>;
  for (int i = kWidth; i <= count; i += kWidth) AddRegister<T>(from, sum);
  if constexpr (kWidth > 4)
    if ((count & 4) != 0) AddRegister<Vec4>(from, sum);
  if ((count & 2) != 0) AddRegister<Vec2, 2>(from, sum);
  if ((count & 1) != 0) AddRegister<double>(from, sum);
}

template <class T>
void AddColumns(const double* const* from, double* const* to, int first, int count,
                const RowRun* runs, const RowRun* end) {
  for (int n = 0; n < count; ++n) {  // each has one row less of the first run
    const int skipped = first + n - runs->from;
    AddNumbers<T>(from[n] + first + n, runs->length - skipped, to[n] + runs->to + skipped);
  }
  for (++runs; runs != end; ++runs)
    for (int n = 0; n < count; ++n)
      AddNumbers<T>(from[n] + runs->from, runs->length, to[n] + runs->to);
}

constexpr int kChains = 12;  // more than hide the latency of a multiply-add

template <class T>
double MultiplyAdd(long rounds, double factor) {
  T sum[kChains];
  for (int i = 0; i < kChains; ++i) sum[i] = T{} + (1.0 + i);
  for (long round = 0; round < rounds; ++round)
    for (int i = 0; i < kChains; ++i) sum[i] = sum[i] * factor + 1.0;
  for (int i = 1; i < kChains; ++i) sum[0] += sum[i];
  return sum[0][0];
}

template <class T>
constexpr FrontKernels MakeFrontKernels(const char* name) {
  return {name,          FactorRange<T>, SubtractColumns<T>,     MultiplyBelow<T>,
          AddColumns<T>, MultiplyAdd<T>, 2 * kChains * kLanes<T>};
}

}  // namespace
}  // namespace drape
