// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <algorithm>

#include "physics/linalg/supernodal_factor.h"
#include "physics/util/math/simd.h"

namespace drape {
namespace {

// One supernode: its triangle and the rows below it in one column-major panel.
struct Supernode {
  int column, width, rows;
  const double* panel;
  const int* row;

  const double* at(int i, int j) const { return panel + static_cast<std::ptrdiff_t>(j) * rows + i; }
};

Supernode GetSupernode(const SupernodalPattern& p, const double* number, int s) {
  return {p.first_column[s], p.first_column[s + 1] - p.first_column[s],
          p.first_row[s + 1] - p.first_row[s], number + p.first_number[s],
          p.row.data() + p.first_row[s]};
}

// Solves with one right-hand side: y holds the rows of a panel.

// How far ahead numbers of L are read [numbers]: past the columns at hand, in the next ones.
int Ahead(const Supernode& s) { return std::max(1024, 4 * s.rows); }

// Solves columns j … j + N of L·y = b and subtracts their contribution from the rows of y below.
template <int N>
void ForwardColumns(const Supernode& s, int j, double* y) {
  double x[N];
  for (int c = 0; c < N; ++c) {
    x[c] = y[j + c];
    for (int k = 0; k < c; ++k) x[c] -= *s.at(j + c, j + k) * x[k];
    y[j + c] = x[c] /= *s.at(j + c, j + c);
  }
  const double* column[N];
  for (int c = 0; c < N; ++c) column[c] = s.at(0, j + c);
  const int ahead = Ahead(s);
  int i = j + N;
  for (; i + 8 <= s.rows; i += 8) {
    Vec4 rows = LoadAs<Vec4>(y + i), next = LoadAs<Vec4>(y + i + 4);
    for (int c = 0; c < N; ++c) {
      __builtin_prefetch(column[c] + i + ahead);
      rows -= LoadAs<Vec4>(column[c] + i) * x[c];
      next -= LoadAs<Vec4>(column[c] + i + 4) * x[c];
    }
    Store(rows, y + i);
    Store(next, y + i + 4);
  }
  for (; i < s.rows; ++i) {
    double sum = y[i];
    for (int c = 0; c < N; ++c) sum -= column[c][i] * x[c];
    y[i] = sum;
  }
}

// Solves columns j … j + N of Lᵀ·x = y.
template <int N>
void BackwardColumns(const Supernode& s, int j, double* y) {
  const double* column[N];
  for (int c = 0; c < N; ++c) column[c] = s.at(0, j + c);
  const int ahead = Ahead(s);
  Vec4 sums[N] = {}, next[N] = {};
  int i = j + N;
  for (; i + 8 <= s.rows; i += 8) {
    const Vec4 rows = LoadAs<Vec4>(y + i), next_rows = LoadAs<Vec4>(y + i + 4);
    for (int c = 0; c < N; ++c) {
      __builtin_prefetch(column[c] + i - ahead);
      sums[c] += LoadAs<Vec4>(column[c] + i) * rows;
      next[c] += LoadAs<Vec4>(column[c] + i + 4) * next_rows;
    }
  }
  if (i + 4 <= s.rows) {
    const Vec4 rows = LoadAs<Vec4>(y + i);
    for (int c = 0; c < N; ++c) sums[c] += LoadAs<Vec4>(column[c] + i) * rows;
    i += 4;
  }
  double x[N];
  for (int c = 0; c < N; ++c) {
    sums[c] += next[c];
    x[c] = y[j + c] - ((sums[c][0] + sums[c][1]) + (sums[c][2] + sums[c][3]));
  }
  for (; i < s.rows; ++i)
    for (int c = 0; c < N; ++c) x[c] -= *s.at(i, j + c) * y[i];
  for (int c = N - 1; c >= 0; --c) {
    for (int k = c + 1; k < N; ++k) x[c] -= *s.at(j + k, j + c) * x[k];
    y[j + c] = x[c] /= *s.at(j + c, j + c);
  }
}

void BackwardOne(const Supernode& s, double* b, double* y) {
  for (int i = 0; i < s.rows; ++i) y[i] = b[s.row[i]];
  int j = s.width;
  ForEachChunk<4>(s.width, [&]<int N>(int) { BackwardColumns<N>(s, j -= N, y); });
  std::copy_n(y, s.width, b + s.column);
}

// Solves with many right-hand sides.

// V registers of each row of b, from one column on.
template <int V>
struct Columns {
  double* data;
  std::ptrdiff_t stride;

  double* row(int i) const { return data + i * stride; }
};

// R rows × V registers of b: as many as fit into 16 vector registers beside a row and a number of
// L.
template <int R, int V>
struct Tile {
  Vec4 value[R][V];  // initialised with the rows: zeroing it first costs as much as the products

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
constexpr int kTileRows = V == 3   ? 4
                          : V == 2 ? 6
                                   : 8;

// Solves the own rows i … i + R of L·y = b.
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

// Subtracts the contribution of the own rows from the rows i … i + R below.
template <int R, int V>
void ForwardBelow(const Supernode& s, int i, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int r = 0; r < R; ++r) tile.Load(r, b.row(s.row[i + r]));
  for (int j = 0; j < s.width; ++j)
    for (int r = 0; r < R; ++r) tile.Subtract(r, *s.at(i + r, j), b.row(s.column + j));
  for (int r = 0; r < R; ++r) tile.Save(r, 1.0, b.row(s.row[i + r]));
}

// Solves the own rows j … j + R of Lᵀ·x = y. From the last row on: then the order of a sum does not
// depend on R.
template <int R, int V>
void BackwardOwn(const Supernode& s, int j, const Columns<V>& b) {
  Tile<R, V> tile;
  for (int r = 0; r < R; ++r) tile.Load(r, b.row(s.column + j + r));
  for (int i = s.rows - 1; i >= j + R; --i)
    for (int r = 0; r < R; ++r) tile.Subtract(r, *s.at(i, j + r), b.row(s.row[i]));
  for (int r = R - 1; r >= 0; --r) {
    for (int k = R - 1; k > r; --k) tile.Subtract(r, *s.at(j + k, j + r), b.row(s.column + j + k));
    tile.Save(r, 1.0 / *s.at(j + r, j + r), b.row(s.column + j + r));
  }
}

template <int V>
void Forward(const Supernode& s, const Columns<V>& b) {
  constexpr int kRows = kTileRows<V>;
  int i = 0;
  for (; i + kRows <= s.width; i += kRows) ForwardOwn<kRows, V>(s, i, b);
  for (; i < s.width; ++i) ForwardOwn<1, V>(s, i, b);
  for (; i + kRows <= s.rows; i += kRows) ForwardBelow<kRows, V>(s, i, b);
  for (; i < s.rows; ++i) ForwardBelow<1, V>(s, i, b);
}

template <int V>
void Backward(const Supernode& s, const Columns<V>& b) {
  constexpr int kRows = kTileRows<V>;
  int j = s.width;
  for (; j >= kRows; j -= kRows) BackwardOwn<kRows, V>(s, j - kRows, b);
  for (; j > 0; --j) BackwardOwn<1, V>(s, j - 1, b);
}

}  // namespace

void SupernodalFactor::Solve(const double* number, double* b, FactorWorkspace* workspace,
                             int threads) const {
  // The vectors that supernodes pass to their parents.
  const bool alone = threads <= 1;
  const std::ptrdiff_t* const place = (alone ? vector_place_alone_ : vector_place_).data();
  workspace->panel.resize(threads);
  workspace->subtree.resize(threads);
  AlignedNumbers& passed = alone ? workspace->subtree[0] : workspace->shared;
  passed.Resize((alone ? alone_size_ : shared_size_) + kMargin);
  const auto forward = [&](const Supernode& s, int n) {
    double* const y = passed.data() + place[n];
    std::copy_n(b + s.column, s.width, y);
    std::fill(y + s.width, y + s.rows, 0.0);
    for (int k = plan_.first_child[n]; k < plan_.first_child[n + 1]; ++k) {
      const int c = plan_.child[k];
      const double* from = passed.data() + place[c] + pattern_.width(c);
      for (int r = plan_.first_run[c]; r < plan_.first_run[c + 1]; ++r) {
        const RowRun& run = plan_.run[r];
        for (int i = 0; i < run.length; ++i) y[run.to + i] += from[run.from + i];
      }
    }
    ForEachChunk<4>(s.width, [&]<int N>(int j) { ForwardColumns<N>(s, j, y); });
    std::copy_n(y, s.width, b + s.column);
  };
  tasks_.VisitUp(threads, [&](const TreeTasks::Worker&, const TreeTasks::Task& task) {
    for (int n = task.first; n <= task.last; ++n) forward(GetSupernode(pattern_, number, n), n);
    return true;
  });
  tasks_.VisitDown(threads, [&](const TreeTasks::Worker& worker, const TreeTasks::Task& task) {
    AlignedNumbers& rows = workspace->panel[worker.thread];
    rows.Resize(panel_size_);
    for (int n = task.last; n >= task.first; --n)
      BackwardOne(GetSupernode(pattern_, number, n), b, rows.data());
    return true;
  });
}

void SupernodalFactor::SolveRows(const double* number, RowMatrix& b, int threads) const {
  CHECK_EQ(b.cols() % 4, 0);
  const int supernodes = pattern_.num_supernodes(), registers = static_cast<int>(b.cols() / 4);
  const int parts = std::min(threads, registers);
#pragma omp parallel for schedule(static, 1) num_threads(parts) if (parts > 1)
  for (int part = 0; part < parts; ++part) {
    const int begin = registers * part / parts, end = registers * (part + 1) / parts;
    for (int n = 0; n < supernodes; ++n)
      ForEachChunk<3>(end - begin, [&]<int V>(int first) {
        Forward(GetSupernode(pattern_, number, n),
                Columns<V>{b.data() + 4 * (begin + first), b.cols()});
      });
    for (int n = supernodes - 1; n >= 0; --n)
      ForEachChunk<3>(end - begin, [&]<int V>(int first) {
        Backward(GetSupernode(pattern_, number, n),
                 Columns<V>{b.data() + 4 * (begin + first), b.cols()});
      });
  }
}

}  // namespace drape
