// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "cuda/factor/plan/front_plan.h"

namespace drape::test {

// A's blocks in the order of plan.entries, row-major. Shape [entries, 3, 3]; `pattern` in the
// mesh's own order.
inline std::vector<double> EntryValues(const FrontPlan& plan, const BlockPattern& pattern,
                                       const BlockMatrix& A) {
  std::vector<double> values;
  for (const FrontEntry& entry : plan.entries) {
    const int row = plan.vertex[entry.row], column = plan.vertex[entry.column];
    const auto begin = pattern.column.begin() + pattern.row_start[row];
    const auto end = pattern.column.begin() + pattern.row_start[row + 1];
    const auto b = std::lower_bound(begin, end, column) - pattern.column.begin();
    values.insert(values.end(), A.block(b), A.block(b) + 9);
  }
  return values;
}

// x in elimination order, shape [3V]; and back.
inline Eigen::VectorXd Permuted(const FrontPlan& plan, const Eigen::VectorXd& x) {
  Eigen::VectorXd result(x.size());
  for (int v = 0; v < plan.num_vertices(); ++v)
    result.segment<3>(3 * plan.position[v]) = x.segment<3>(3 * v);
  return result;
}
inline Eigen::VectorXd Unpermuted(const FrontPlan& plan, const Eigen::VectorXd& x) {
  Eigen::VectorXd result(x.size());
  for (int v = 0; v < plan.num_vertices(); ++v)
    result.segment<3>(3 * v) = x.segment<3>(3 * plan.position[v]);
  return result;
}

// What a device does with a plan, in plain loops over dense fronts: one factor, one update
// workspace, level by level.
class HostMultifrontal {
 public:
  using Rows = Eigen::Map<RowMatrix>;

  explicit HostMultifrontal(const FrontPlan& plan)
      : plan_(plan), factor_(plan.factor_size), update_(plan.update_size) {}

  // A·x = b, all in elimination order; `entries` as EntryValues. False when A is not positive
  // definite.
  bool Solve(const std::vector<double>& entries, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    x = b;
    for (int level = 0; level < plan_.num_levels(); ++level) {
      // All fronts of a level may write before one of them has read.
      for (const int i : Level(level)) MakeUpdate(plan_.fronts[i]).setConstant(kNan);
      for (const int i : Level(level))
        if (!Eliminate(plan_.fronts[i], entries, x)) return false;
    }
    for (int level = plan_.num_levels() - 1; level >= 0; --level)
      for (const int i : Level(level)) Substitute(plan_.fronts[i], x);
    return true;
  }
  const std::vector<double>& factor() const { return factor_; }

 private:
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  std::span<const int> Level(int level) const {
    return std::span(plan_.level_front)
        .subspan(plan_.level_start[level], plan_.level_start[level + 1] - plan_.level_start[level]);
  }
  Rows MakePanel(const Front& f) {
    return Rows(factor_.data() + f.factor_offset, f.pivots + f.border, f.pivots);
  }
  Rows MakeUpdate(const Front& f) {
    return Rows(update_.data() + f.update_offset, f.border + 1, f.border);
  }

  bool Eliminate(const Front& f, const std::vector<double>& entries, Eigen::VectorXd& x) {
    const int p = f.pivots, q = f.border;
    Rows panel = MakePanel(f);
    RowMatrix update = RowMatrix::Zero(q + 1, q), right = RowMatrix::Zero(1, p);
    AddEntries(f, entries, panel);
    right.leftCols(f.true_pivots) = x.segment(f.first_dof, f.true_pivots).transpose();
    for (int c = f.child_start; c < f.child_end; ++c)
      AddChild(plan_.children[c], p, panel, update, right);
    const Eigen::LLT<Eigen::MatrixXd> pivots(panel.topRows(p));
    if (pivots.info() != Eigen::Success) return false;
    panel.topRows(p) = pivots.matrixL();
    const auto L11 = panel.topRows(p).triangularView<Eigen::Lower>();
    L11.transpose().solveInPlace<Eigen::OnTheRight>(panel.bottomRows(q));
    L11.transpose().solveInPlace<Eigen::OnTheRight>(right);
    update.topRows(q) -= panel.bottomRows(q) * panel.bottomRows(q).transpose();
    update.bottomRows(1) -= right * panel.bottomRows(q).transpose();
    x.segment(f.first_dof, f.true_pivots) = right.leftCols(f.true_pivots).transpose();
    StoreUpdate(update, MakeUpdate(f));
    return true;
  }

  void AddEntries(const Front& f, const std::vector<double>& entries, Rows& panel) const {
    panel.setZero();
    for (int k = f.true_pivots; k < f.pivots; ++k) panel(k, k) = 1;
    for (int e = f.entry_start; e < f.entry_end; ++e) {
      const FrontEntry& entry = plan_.entries[e];
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          panel(entry.panel_row + r, entry.panel_column + c) += entries[9 * e + 3 * r + c];
    }
  }

  // Gathers, as a device does: each place of the front looks for its row and column of the child.
  void AddChild(const FrontChild& child, int p, Rows& panel, RowMatrix& update, RowMatrix& right) {
    const Front& f = plan_.fronts[child.front];
    const Rows from = MakeUpdate(f);
    const std::int16_t* row = plan_.child_row.data() + child.row_start;
    const auto rows = static_cast<int>(panel.rows());
    for (int c = 0; c < rows; ++c) {
      if (row[c] < 0) continue;
      for (int r = c; r < rows; ++r)
        if (row[r] >= 0) (c < p ? panel(r, c) : update(r - p, c - p)) += from(row[r], row[c]);
      (c < p ? right(0, c) : update(update.rows() - 1, c - p)) += from(f.border, row[c]);
    }
  }

  // The upper triangle stays undefined, as on a device.
  static void StoreUpdate(const RowMatrix& update, Rows to) {
    for (int r = 0; r < update.rows(); ++r)
      for (int c = 0; c < update.cols() && c <= r; ++c) to(r, c) = update(r, c);
  }

  void Substitute(const Front& f, Eigen::VectorXd& x) {
    const Rows panel = MakePanel(f);
    Eigen::VectorXd border = Eigen::VectorXd::Zero(f.border), y = Eigen::VectorXd::Zero(f.pivots);
    for (int r = 0; r < f.border; ++r)
      if (const int dof = plan_.border_dof[f.border_start + r]; dof >= 0) border[r] = x[dof];
    y.head(f.true_pivots) = x.segment(f.first_dof, f.true_pivots);
    y -= panel.bottomRows(f.border).transpose() * border;
    panel.topRows(f.pivots).triangularView<Eigen::Lower>().transpose().solveInPlace(y);
    x.segment(f.first_dof, f.true_pivots) = y.head(f.true_pivots);
  }

  const FrontPlan& plan_;
  std::vector<double> factor_, update_;
};

}  // namespace drape::test
