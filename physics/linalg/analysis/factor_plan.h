// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/linalg/kernels/front_kernels.h"

namespace drape {

// The layout of a supernodal factor L, from CHOLMOD's analysis [Liu 1992]. Supernode s holds the
// columns first_column[s] … first_column[s + 1] as a dense column-major panel from first_number[s]
// on. The rows of the panel are row[first_row[s] … first_row[s + 1]], of which the first ones are
// its own columns.
struct SupernodalPattern {
  std::vector<int> first_column, first_row, first_number;  // [S + 1] each
  std::vector<int> row;

  int num_supernodes() const { return static_cast<int>(first_column.size()) - 1; }
  int width(int s) const { return first_column[s + 1] - first_column[s]; }
  int num_rows(int s) const { return first_row[s + 1] - first_row[s]; }
  int num_below(int s) const { return num_rows(s) - width(s); }  // its update matrix's size
};

// The lower triangle of a symmetric matrix in the order of elimination, in compressed columns, and
// for each stored number its source in the array of numbers from which A is read.
struct LowerTriangle {
  std::vector<int> column_start, row, source;
};

// A multifrontal factorisation's plan [Duff 1983; Liu 1992]. The front of a supernode has the
// rows of its panel. It adds up the numbers of A in its own columns and the update matrices of its
// children, factors its own columns, and passes the rest to its parent as an update matrix.
struct FactorPlan {
  // A number of A: its place in the panel (FrontPanel) and where it is read.
  struct Entry {
    int place, source;
  };

  std::vector<int> parent;              // [S]; −1 of a root
  std::vector<int> first_child, child;  // [S + 1], children in ascending order
  std::vector<int> first_run;           // [S + 1]
  std::vector<RowRun> run;              // rows of an update matrix → rows of the parent's front
  std::vector<int> first_entry;         // [S + 1]
  std::vector<Entry> entry;
  std::vector<double> work;  // [S] about proportional to the time of a front
  double flops = 0.0;        // of all columns: Σ r² for r rows, diagonal included
};

FactorPlan MakeFactorPlan(const SupernodalPattern& pattern, const LowerTriangle& lower);

// Places for what the supernodes first … last, which are visited in this order, pass to their
// parents: each is alive until its parent has been visited. numbers: [S], how many each passes.
// Returns the offsets of first … last, and in *size how many numbers they need.
std::vector<std::ptrdiff_t> PlacePassed(const FactorPlan& plan,
                                        const std::vector<std::ptrdiff_t>& numbers, int first,
                                        int last, std::size_t* size);

// The pattern of a factor of the 3V unknowns, three of a vertex one after the other.
struct SymbolicAnalysis {
  LowerTriangle lower;  // its sources are places in the block matrix
  SupernodalPattern pattern;
};
// Analyses by CHOLMOD. order: of elimination, [V]. Throws std::runtime_error for a factor of over
// 2³¹ numbers, and std::bad_alloc.
SymbolicAnalysis AnalyseSymbolically(const BlockPattern& pattern, const std::vector<int>& order);

}  // namespace drape
