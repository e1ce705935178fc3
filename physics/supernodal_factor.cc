// SPDX-License-Identifier: Apache-2.0
#include "physics/supernodal_factor.h"

#include <glog/logging.h>

#include "physics/simd.h"

namespace drape {
namespace {

// One supernode: its triangle and the rows below it, in one column-major panel.
struct Supernode {
  int column, width, rows;
  const double* panel;
  const int* row;

  const double* at(int i, int j) const { return panel + static_cast<std::ptrdiff_t>(j) * rows + i; }
};

Supernode GetSupernode(const SupernodalFactor& f, int s) {
  return {f.first_column[s], f.first_column[s + 1] - f.first_column[s],
          f.first_row[s + 1] - f.first_row[s], f.number + f.first_number[s],
          f.row.data() + f.first_row[s]};
}

// V registers of each row of b, from one column on.
template <int V>
struct Columns {
  double* data;
  std::ptrdiff_t stride;

  double* row(int i) const { return data + i * stride; }
};

// R rows × V registers: as many as 16 vector registers hold beside V of b and one of L.
template <int R, int V>
struct Tile {
  Vec4 sum[R][V] = {};

  // sum += L(i0 + r, j)·b(row).
  void AddProduct(const double* l, std::ptrdiff_t l_stride, const double* b) {
    Vec4 row[V];
    for (int v = 0; v < V; ++v) row[v] = LoadAs<Vec4>(b + 4 * v);
    for (int r = 0; r < R; ++r) {
      const double factor = l[r * l_stride];
      for (int v = 0; v < V; ++v) sum[r][v] += factor * row[v];
    }
  }
  // row ← (row − sum)·scale.
  void Finish(int r, double scale, double* b) const {
    for (int v = 0; v < V; ++v) Store((LoadAs<Vec4>(b + 4 * v) - sum[r][v]) * scale, b + 4 * v);
  }
};
template <int V>
constexpr int kTileRows = V >= 4 ? 2 : V == 3 ? 4 : V == 2 ? 6 : 8;

// Rows i … i + R of L·y = b: own rows are solved, rows below receive what the own ones give them.
template <int R, int V>
void ForwardTile(const Supernode& s, int i, const Columns<V>& b) {
  const bool own = i < s.width;
  const int known = own ? i : s.width;
  Tile<R, V> tile;
  for (int j = 0; j < known; ++j) tile.AddProduct(s.at(i, j), 1, b.row(s.column + j));
  for (int r = 0; r < R; ++r) {
    double* row = b.row(own ? s.column + i + r : s.row[i + r]);
    if (own)
      for (int k = 0; k < r; ++k)
        for (int v = 0; v < V; ++v)
          tile.sum[r][v] += *s.at(i + r, i + k) * LoadAs<Vec4>(b.row(s.column + i + k) + 4 * v);
    tile.Finish(r, own ? 1.0 / *s.at(i + r, i + r) : 1.0, row);
  }
}

// Own rows j … j + R of Lᵀ·x = y.
template <int R, int V>
void BackwardTile(const Supernode& s, int j, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int i = j + R; i < s.rows; ++i) tile.AddProduct(s.at(i, j), s.rows, b.row(s.row[i]));
  for (int r = R - 1; r >= 0; --r) {
    for (int k = r + 1; k < R; ++k)
      for (int v = 0; v < V; ++v)
        tile.sum[r][v] += *s.at(j + k, j + r) * LoadAs<Vec4>(b.row(s.column + j + k) + 4 * v);
    tile.Finish(r, 1.0 / *s.at(j + r, j + r), b.row(s.column + j + r));
  }
}

template <int V>
void Forward(const Supernode& s, const Columns<V>& b) {
  constexpr int R = kTileRows<V>;
  int i = 0;
  for (; i + R <= s.width; i += R) ForwardTile<R, V>(s, i, b);
  for (; i < s.width; ++i) ForwardTile<1, V>(s, i, b);
  for (; i + R <= s.rows; i += R) ForwardTile<R, V>(s, i, b);
  for (; i < s.rows; ++i) ForwardTile<1, V>(s, i, b);
}

template <int V>
void Backward(const Supernode& s, const Columns<V>& b) {
  constexpr int R = kTileRows<V>;
  int j = s.width;
  for (; j >= R; j -= R) BackwardTile<R, V>(s, j - R, b);
  for (; j > 0; --j) BackwardTile<1, V>(s, j - 1, b);
}

}  // namespace

void SolveRows(const SupernodalFactor& factor, RowMatrix& b) {
  CHECK_EQ(b.cols() % 4, 0);
  const int supernodes = static_cast<int>(factor.first_column.size()) - 1;
  const int registers = static_cast<int>(b.cols() / 4);
  for (int n = 0; n < supernodes; ++n)
    ForEachChunk<5>(registers, [&]<int V>(int first) {
      Forward(GetSupernode(factor, n), Columns<V>{b.data() + 4 * first, b.cols()});
    });
  for (int n = supernodes - 1; n >= 0; --n)
    ForEachChunk<5>(registers, [&]<int V>(int first) {
      Backward(GetSupernode(factor, n), Columns<V>{b.data() + 4 * first, b.cols()});
    });
}

}  // namespace drape
