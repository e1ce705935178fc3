// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/linalg/kernels/front_kernels.h"

namespace drape {

// Hold it during each call of METIS, which seeds the one random number generator of the process
// at its start: calls at the same time would take numbers from one another, and give another order
// and other last digits of results.
inline std::mutex& MetisLock() {
  static std::mutex one_at_a_time;
  return one_at_a_time;
}

// The order in which a factorisation eliminates the vertices of a pattern, a postorder of its
// elimination tree [Liu 1992].
struct EliminationOrder {
  std::vector<int> vertex;  // [V] the k-th
  // Operations of a factorisation of as many scalars, 1/27 of the real one: in this order, and in
  // the order of the last dissection.
  double operations = 0.0, dissected_operations = 0.0;
};

// Nested dissection by METIS [George 1973].
EliminationOrder DissectVertices(const BlockPattern& pattern);

// An order for another pattern of the same vertices. Two that a new block joins across a separator
// would make its two sides one: of them, as few as a greedy cover finds move into it, in a fraction
// of the time of a dissection. Where a factorisation would then take a quarter more operations than
// after the last dissection there is a new one.
EliminationOrder AdaptOrder(const EliminationOrder& order, const BlockPattern& pattern,
                            const BlockPattern& other);

// The place of each vertex in an order.
std::vector<int> FindPlaces(const std::vector<int>& order);

// The elimination tree: the parent of each place in the order, V of a root.
std::vector<int> EliminationTree(const BlockPattern& pattern, const std::vector<int>& order);

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
