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

// R rows × V registers of b: as many as 16 vector registers hold beside a row and a number of L.
template <int R, int V>
struct Tile {
  Vec4 value[R]
            [V];  // starts with the rows themselves: zeroing it first costs as much as the products

  void Load(int r, const double* b) {
    for (int v = 0; v < V; ++v) value[r][v] = LoadAs<Vec4>(b + 4 * v);
  }
  void Save(int r, double scale, double* b) const {
    for (int v = 0; v < V; ++v) Store(value[r][v] * scale, b + 4 * v);
  }
  void Subtract(int r, double l, const double* b) {
    for (int v = 0; v < V; ++v) value[r][v] -= l * LoadAs<Vec4>(b + 4 * v);
  }
};
template <int V>
constexpr int kTileRows = V == 3 ? 4 : V == 2 ? 6 : 8;

// Own rows i … i + R of L·y = b.
template <int R, int V>
void ForwardOwn(const Supernode& s, int i, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int r = 0; r < R; ++r) tile.Load(r, b.row(s.column + i + r));
  for (int j = 0; j < i; ++j)
    for (int r = 0; r < R; ++r) tile.Subtract(r, *s.at(i + r, j), b.row(s.column + j));
  for (int r = 0; r < R; ++r) {
    for (int k = 0; k < r; ++k) tile.Subtract(r, *s.at(i + r, i + k), b.row(s.column + i + k));
    tile.Save(r, 1.0 / *s.at(i + r, i + r), b.row(s.column + i + r));
  }
}

// Rows i … i + R below receive what the own ones give them.
template <int R, int V>
void ForwardBelow(const Supernode& s, int i, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int r = 0; r < R; ++r) tile.Load(r, b.row(s.row[i + r]));
  for (int j = 0; j < s.width; ++j)
    for (int r = 0; r < R; ++r) tile.Subtract(r, *s.at(i + r, j), b.row(s.column + j));
  for (int r = 0; r < R; ++r) tile.Save(r, 1.0, b.row(s.row[i + r]));
}

// Own rows j … j + R of Lᵀ·x = y.
template <int R, int V>
void BackwardOwn(const Supernode& s, int j, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int r = 0; r < R; ++r) tile.Load(r, b.row(s.column + j + r));
  for (int i = j + R; i < s.rows; ++i)
    for (int r = 0; r < R; ++r) tile.Subtract(r, *s.at(i, j + r), b.row(s.row[i]));
  for (int r = R - 1; r >= 0; --r) {
    for (int k = r + 1; k < R; ++k) tile.Subtract(r, *s.at(j + k, j + r), b.row(s.column + j + k));
    tile.Save(r, 1.0 / *s.at(j + r, j + r), b.row(s.column + j + r));
  }
}

template <int V>
void Forward(const Supernode& s, const Columns<V>& b) {
  constexpr int R = kTileRows<V>;
  int i = 0;
  for (; i + R <= s.width; i += R) ForwardOwn<R, V>(s, i, b);
  for (; i < s.width; ++i) ForwardOwn<1, V>(s, i, b);
  for (; i + R <= s.rows; i += R) ForwardBelow<R, V>(s, i, b);
  for (; i < s.rows; ++i) ForwardBelow<1, V>(s, i, b);
}

template <int V>
void Backward(const Supernode& s, const Columns<V>& b) {
  constexpr int R = kTileRows<V>;
  int j = s.width;
  for (; j >= R; j -= R) BackwardOwn<R, V>(s, j - R, b);
  for (; j > 0; --j) BackwardOwn<1, V>(s, j - 1, b);
}

}  // namespace

void SolveRows(const SupernodalFactor& factor, RowMatrix& b) {
  CHECK_EQ(b.cols() % 4, 0);
  const int supernodes = static_cast<int>(factor.first_column.size()) - 1;
  const int registers = static_cast<int>(b.cols() / 4);
  for (int n = 0; n < supernodes; ++n)
    ForEachChunk<3>(registers, [&]<int V>(int first) {
      Forward(GetSupernode(factor, n), Columns<V>{b.data() + 4 * first, b.cols()});
    });
  for (int n = supernodes - 1; n >= 0; --n)
    ForEachChunk<3>(registers, [&]<int V>(int first) {
      Backward(GetSupernode(factor, n), Columns<V>{b.data() + 4 * first, b.cols()});
    });
}

}  // namespace drape
