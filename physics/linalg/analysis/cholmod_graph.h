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

}  // namespace drape
