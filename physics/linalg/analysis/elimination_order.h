// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cholmod.h>

#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// A graph that CHOLMOD orders and analyses, with CHOLMOD's workspace. All throw std::bad_alloc.
class CholmodGraph {
 public:
  // The graph of the vertices of a pattern.
  explicit CholmodGraph(const BlockPattern& pattern);
  // The graph of the lower triangle of a matrix, in compressed columns.
  CholmodGraph(const std::vector<int>& column_start, const std::vector<int>& row);
  CholmodGraph(const CholmodGraph&) = delete;
  CholmodGraph& operator=(const CholmodGraph&) = delete;
  ~CholmodGraph();

  // Nested dissection by METIS [George 1973].
  std::vector<int> Dissect();
  // Analyses a supernodal factorisation in the order given, which is brought into a postorder of
  // the elimination tree, or in the order of the numbers. The result is the graph's. Throws
  // std::runtime_error where the factor has more than 2³¹ numbers.
  const cholmod_factor& AnalysePostordered(std::vector<int>& order);
  const cholmod_factor& AnalyseAsIs();
  // Operations of a factorisation, after an analysis.
  double operations() const { return common_.fl; }

 private:
  void Start(std::size_t nodes, std::size_t numbers);
  const cholmod_factor& Analyse(int ordering, int* order);
  void Require(bool succeeded) const;

  cholmod_common common_{};
  cholmod_sparse* graph_ = nullptr;
  cholmod_factor* factor_ = nullptr;
};

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

}  // namespace drape
