// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "physics/linalg/block_matrix.h"

namespace drape {

// Where the numbers of a supernodal factor L stand, as CHOLMOD's analysis finds it: supernode s
// holds the columns first_column[s] … first_column[s + 1] as a dense column-major panel from
// first_number[s] on, whose rows are row[first_row[s] … first_row[s + 1]], the first ones being its
// own columns.
struct SupernodalPattern {
  std::vector<int> first_column, first_row, first_number;  // [S + 1] each
  std::vector<int> row;

  int num_supernodes() const { return static_cast<int>(first_column.size()) - 1; }
};

// The factorisation A = L·Lᵀ over such a pattern, left-looking: a supernode receives products of
// the earlier ones, planned once, and is then factored itself. Without the BLAS: the supernodes of
// a cloth are so small that calling it costs as much as the products, and threads wait for its
// locks. Immutable, so that threads share it; numbers and workspace are the caller's. Each number
// is summed in one order, whatever the machine's vectors.
class SupernodalFactor {
 public:
  explicit SupernodalFactor(SupernodalPattern pattern);

  // Of L with a margin that vectors may read: the size of `number` below.
  std::size_t num_numbers() const;
  // Where L's number of a row and a column stands, which the pattern has.
  int FindPlace(int row, int column) const;

  // In place: the lower triangle of A in L's places, 0 elsewhere, becomes L. False where A is not
  // positive definite.
  [[nodiscard]] bool Factor(double* number, std::vector<double>* workspace) const;

  // In place, b ← L⁻ᵀ·L⁻¹·b, shape [n].
  void Solve(const double* number, double* b, std::vector<double>* workspace) const;
  // The same, shape [n, m], m a multiple of 4 (pad with zero columns). CHOLMOD's own solve gathers
  // and scatters columns n apart (measured with 39 right-hand sides on 2,700 vertices: 15 ms by
  // BLAS calls on rows, 9 ms by this).
  void SolveRows(const double* number, RowMatrix& b) const;

 private:
  // What a supernode receives: the product of the rows of an earlier one from `first` on, of which
  // `own` are columns of the receiver, with these.
  struct Update {
    int from, first, own;
    int place;  // in receiving_row_
  };

  void PlanUpdates();

  SupernodalPattern pattern_;
  std::vector<Update> updates_;
  std::vector<int> first_update_;   // [S + 1]
  std::vector<int> receiving_row_;  // row of the receiver's panel for each row of each update
  int most_rows_ = 0;               // of a panel
};

}  // namespace drape
