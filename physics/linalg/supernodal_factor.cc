// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/supernodal_factor.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/util/math/simd.h"

namespace drape {
namespace {

constexpr int kMargin = 3;     // doubles that a tile may read past the end of a panel
constexpr int kColumns = 4;    // of a tile
constexpr int kRegisters = 3;  // of its rows: 12 sums fill the 16 vector registers

struct Panel {
  double* number;
  int rows, width;

  double* at(int i, int j) const { return number + static_cast<std::ptrdiff_t>(j) * rows + i; }
};

Panel GetPanel(const SupernodalPattern& p, double* number, int s) {
  return {number + p.first_number[s], p.first_row[s + 1] - p.first_row[s],
          p.first_column[s + 1] - p.first_column[s]};
}

int RoundedUp(int rows) { return (rows + 3) / 4 * 4; }

// Computes 4·V rows × N columns of A·Bᵀ, where A and B are rows of one panel, from `a` and `b` on,
// with `depth` columns.
template <int V, int N>
inline __attribute__((always_inline)) void MultiplyTile(const double* a, const double* b,
                                                        std::ptrdiff_t stride, int depth,
                                                        double* product, std::ptrdiff_t to) {
  Vec4 sum[N][V];
  for (int n = 0; n < N; ++n)
    for (int v = 0; v < V; ++v) sum[n][v] = Vec4{};
  for (int k = 0; k < depth; ++k, a += stride, b += stride) {
    Vec4 rows[V];
    for (int v = 0; v < V; ++v) rows[v] = LoadAs<Vec4>(a + 4 * v);
    for (int n = 0; n < N; ++n)
      for (int v = 0; v < V; ++v) sum[n][v] += rows[v] * b[n];
  }
  for (int n = 0; n < N; ++n)
    for (int v = 0; v < V; ++v) Store(sum[n][v], product + n * to + 4 * v);
}

// Computes rows i … panel.rows of the panel times its rows i … i + N, over `depth` columns. Column
// n of the product starts at product[n·RoundedUp(rows)]; numbers after its rows are padding.
template <int N>
void MultiplyRows(const Panel& panel, int i, int depth, double* product) {
  const int rows = panel.rows - i;
  ForEachChunk<kRegisters>(RoundedUp(rows) / 4, [&]<int V>(int first) {
    MultiplyTile<V, N>(panel.at(i + 4 * first, 0), panel.at(i, 0), panel.rows, depth,
                       product + 4 * first, RoundedUp(rows));
  });
}

// Factors columns j … j + N of a panel whose earlier columns are done.
template <int N>
bool FactorColumns(const Panel& panel, int j, double* product) {
  const int rows = panel.rows - j, stride = RoundedUp(rows);
  double* column[N];
  for (int n = 0; n < N; ++n) column[n] = panel.at(j, j + n);
  if (j > 0) {
    MultiplyRows<N>(panel, j, j, product);
    for (int n = 0; n < N; ++n)
      for (int i = n; i < rows; ++i) column[n][i] -= product[n * stride + i];
  }
  double inverse[N];
  for (int n = 0; n < N; ++n) {
    for (int m = n; m < N; ++m)
      for (int k = 0; k < n; ++k) column[n][m] -= column[k][m] * column[k][n];
    if (!(column[n][n] > 0.0)) return false;
    column[n][n] = std::sqrt(column[n][n]);
    inverse[n] = 1.0 / column[n][n];
    for (int m = n + 1; m < N; ++m) column[n][m] *= inverse[n];
  }
  const auto solve = [&]<class T>(int i) {
    T x[N];
    for (int n = 0; n < N; ++n) {
      x[n] = LoadAs<T>(column[n] + i);
      for (int k = 0; k < n; ++k) x[n] -= x[k] * column[k][n];
      x[n] *= inverse[n];
      Store(x[n], column[n] + i);
    }
  };
  int i = N;
  for (; i + 4 <= rows; i += 4) solve.template operator()<Vec4>(i);
  for (; i < rows; ++i) solve.template operator()<double>(i);
  return true;
}

bool FactorPanel(const Panel& panel, double* product) {
  bool positive = true;
  ForEachChunk<kColumns>(panel.width, [&]<int N>(int j) {
    positive = positive && FactorColumns<N>(panel, j, product);
  });
  return positive;
}

// Subtracts from the receiver the contribution of the rows of an earlier panel from `first` on, of
// which the first `own` are columns of the receiver. `to` holds the row of the receiver for each of
// these rows.
void Receive(const Panel& receiver, const Panel& from, int first, int own, const int* to,
             double* product) {
  ForEachChunk<kColumns>(own, [&]<int N>(int j) {
    MultiplyRows<N>(from, first + j, from.width, product);
    const int rows = from.rows - first - j, stride = RoundedUp(rows);
    const bool one_run = to[j + rows - 1] - to[j] == rows - 1;
    for (int n = 0; n < N; ++n) {
      double* column = receiver.at(0, to[j + n]);
      const double* given = product + n * stride;
      if (one_run) {
        column += to[j];
        for (int i = n; i < rows; ++i) column[i] -= given[i];
      } else {
        for (int i = n; i < rows; ++i) column[to[j + i]] -= given[i];
      }
    }
  });
}

}  // namespace

SupernodalFactor::SupernodalFactor(SupernodalPattern pattern) : pattern_(std::move(pattern)) {
  for (int s = 0; s < pattern_.num_supernodes(); ++s)
    max_rows_ = std::max(max_rows_, pattern_.first_row[s + 1] - pattern_.first_row[s]);
  PlanUpdates();
}

void SupernodalFactor::PlanUpdates() {
  const SupernodalPattern& p = pattern_;
  const int supernodes = p.num_supernodes();
  std::vector<int> supernode_of(p.first_column.back());
  for (int s = 0; s < supernodes; ++s)
    std::fill(supernode_of.begin() + p.first_column[s],
              supernode_of.begin() + p.first_column[s + 1], s);
  // Lists the contributions by giving supernode, then sorts them by receiver; the order of the
  // givers is kept.
  std::vector<std::vector<Update>> received(supernodes);
  for (int s = 0; s < supernodes; ++s) {
    const int* row = p.row.data() + p.first_row[s];
    const int rows = p.first_row[s + 1] - p.first_row[s];
    for (int i = p.first_column[s + 1] - p.first_column[s]; i < rows;) {
      const int receiver = supernode_of[row[i]];
      int end = i;
      while (end < rows && supernode_of[row[end]] == receiver) ++end;
      received[receiver].push_back({s, i, end - i, 0});
      i = end;
    }
  }
  std::vector<int> panel_row(p.first_column.back());
  for (int s = 0; s < supernodes; ++s) {
    first_update_.push_back(static_cast<int>(updates_.size()));
    for (int i = p.first_row[s]; i < p.first_row[s + 1]; ++i)
      panel_row[p.row[i]] = i - p.first_row[s];
    for (Update update : received[s]) {
      update.place = static_cast<int>(receiving_row_.size());
      for (int i = p.first_row[update.from] + update.first; i < p.first_row[update.from + 1]; ++i)
        receiving_row_.push_back(panel_row[p.row[i]]);
      updates_.push_back(update);
    }
  }
  first_update_.push_back(static_cast<int>(updates_.size()));
}

std::size_t SupernodalFactor::num_numbers() const {
  return static_cast<std::size_t>(pattern_.first_number.back()) + kMargin;
}

int SupernodalFactor::FindPlace(int row, int column) const {
  const SupernodalPattern& p = pattern_;
  const int s =
      static_cast<int>(std::upper_bound(p.first_column.begin(), p.first_column.end(), column) -
                       p.first_column.begin()) -
      1;
  const auto begin = p.row.begin() + p.first_row[s], end = p.row.begin() + p.first_row[s + 1];
  const auto found = std::lower_bound(begin, end, row);
  CHECK(found != end && *found == row);
  return p.first_number[s] + (column - p.first_column[s]) * static_cast<int>(end - begin) +
         static_cast<int>(found - begin);
}

bool SupernodalFactor::Factor(double* number, std::vector<double>* workspace,
                              const std::atomic<bool>* cancel) const {
  const auto cancelled = [&] {
    return cancel != nullptr && cancel->load(std::memory_order_relaxed);
  };
  workspace->resize(static_cast<std::size_t>(kColumns) * RoundedUp(max_rows_));
  for (int s = 0; s < pattern_.num_supernodes(); ++s) {
    const Panel panel = GetPanel(pattern_, number, s);
    for (int u = first_update_[s]; u < first_update_[s + 1]; ++u) {
      if (cancelled()) return false;
      const Update& update = updates_[u];
      Receive(panel, GetPanel(pattern_, number, update.from), update.first, update.own,
              receiving_row_.data() + update.place, workspace->data());
    }
    if (cancelled() || !FactorPanel(panel, workspace->data())) return false;
  }
  return true;
}

}  // namespace drape
