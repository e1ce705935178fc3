// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "physics/linalg/block_matrix.h"

namespace drape {

// The layout of a supernodal factor L, from CHOLMOD's analysis [Liu 1992]. Supernode s holds the
// columns first_column[s] … first_column[s + 1] as a dense column-major panel from first_number[s]
// on. The rows of the panel are row[first_row[s] … first_row[s + 1]], of which the first ones are
// its own columns.
struct SupernodalPattern {
  std::vector<int> first_column, first_row, first_number;  // [S + 1] each
  std::vector<int> row;

  int num_supernodes() const { return static_cast<int>(first_column.size()) - 1; }
};

// The factorisation A = L·Lᵀ on such a pattern, left-looking: each supernode receives products of
// earlier ones, which are planned once, and is then factored itself. It does not use the BLAS: the
// supernodes of a cloth are so small that a BLAS call costs as much as the products, and threads
// wait for its locks. The object is immutable and shared by threads; numbers and workspace belong
// to the caller. Each number is summed in the same order whatever the vector width of the machine.
class SupernodalFactor {
 public:
  explicit SupernodalFactor(SupernodalPattern pattern);

  // The size of `number` below: the numbers of L and a margin that vector loads may read.
  std::size_t num_numbers() const;
  // The index of the number of L in a row and a column, which the pattern must contain.
  int FindPlace(int row, int column) const;

  // Factors in place: `number` holds the lower triangle of A at the places of L, zero elsewhere,
  // and holds L afterwards. Returns false when A is not positive definite, and soon after *cancel
  // turns true (cancel may be null).
  [[nodiscard]] bool Factor(double* number, std::vector<double>* workspace,
                            const std::atomic<bool>* cancel = nullptr) const;

  // Solves in place, b ← L⁻ᵀ·L⁻¹·b, shape [n].
  void Solve(const double* number, double* b, std::vector<double>* workspace) const;
  // The same for shape [n, m], with m a multiple of 4 (pad with zero columns). CHOLMOD's own solve
  // gathers and scatters columns that are n numbers apart. Measured with 39 right-hand sides on
  // 2,700 vertices: 15 ms by BLAS calls on rows, 9 ms by this function.
  void SolveRows(const double* number, RowMatrix& b) const;

 private:
  // A product that a supernode receives: the rows of an earlier supernode from `first` on times
  // those of these rows that are columns of the receiver, the first `own` ones.
  struct Update {
    int from, first, own;
    int place;  // in receiving_row_
  };

  void PlanUpdates();

  SupernodalPattern pattern_;
  std::vector<Update> updates_;
  std::vector<int> first_update_;   // [S + 1]
  std::vector<int> receiving_row_;  // row of the receiver's panel for each row of each update
  int max_rows_ = 0;                // largest number of rows of a panel
};

}  // namespace drape
