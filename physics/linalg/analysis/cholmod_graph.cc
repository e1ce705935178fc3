// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/analysis/cholmod_graph.h"

#include <glog/logging.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>

#include "physics/linalg/analysis/metis_lock.h"

namespace drape {

CholmodGraph::CholmodGraph(const BlockPattern& pattern) {
  const int n = pattern.num_vertices();
  Start(n, pattern.num_blocks());
  int* start = static_cast<int*>(graph_->p);
  int* row = static_cast<int*>(graph_->i);
  int count = 0;
  for (int j = 0; j < n; ++j) {
    start[j] = count;
    for (int b = pattern.row_start[j]; b < pattern.row_start[j + 1]; ++b)
      if (pattern.column[b] >= j) row[count++] = pattern.column[b];
  }
  start[n] = count;
}

CholmodGraph::CholmodGraph(const std::vector<int>& column_start, const std::vector<int>& row) {
  Start(column_start.size() - 1, row.size());
  std::copy(column_start.begin(), column_start.end(), static_cast<int*>(graph_->p));
  std::copy(row.begin(), row.end(), static_cast<int*>(graph_->i));
}

CholmodGraph::~CholmodGraph() {
  cholmod_free_factor(&factor_, &common_);
  cholmod_free_sparse(&graph_, &common_);
  cholmod_finish(&common_);
}

void CholmodGraph::Start(std::size_t nodes, std::size_t numbers) {
  CHECK(cholmod_start(&common_));
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.print = 0;
  common_.nmethods = 1;
  graph_ = cholmod_allocate_sparse(nodes, nodes, numbers, 1, 1, -1, CHOLMOD_PATTERN, &common_);
  Require(graph_ != nullptr);
}

std::vector<int> CholmodGraph::Dissect() {
  std::vector<int> order(graph_->nrow);
  const std::lock_guard guard(MetisLock());
  Require(cholmod_metis(graph_, nullptr, 0, 1, order.data(), &common_) != 0);
  return order;
}

const cholmod_factor& CholmodGraph::AnalysePostordered(std::vector<int>& order) {
  const cholmod_factor& factor = Analyse(CHOLMOD_GIVEN, order.data());
  std::copy_n(static_cast<const int*>(factor.Perm), order.size(), order.begin());
  return factor;
}

const cholmod_factor& CholmodGraph::AnalyseAsIs() { return Analyse(CHOLMOD_NATURAL, nullptr); }

const cholmod_factor& CholmodGraph::Analyse(int ordering, int* order) {
  common_.method[0].ordering = ordering;
  common_.postorder = ordering != CHOLMOD_NATURAL;
  cholmod_free_factor(&factor_, &common_);
  factor_ = cholmod_analyze_p(graph_, order, nullptr, 0, &common_);
  Require(factor_ != nullptr);
  return *factor_;
}

// What a mesh can be too large for, or the memory.
void CholmodGraph::Require(bool succeeded) const {
  if (succeeded) return;
  if (common_.status == CHOLMOD_TOO_LARGE)
    throw std::runtime_error("the mesh is too large: its factor has more than 2^31 numbers");
  throw std::bad_alloc();
}

}  // namespace drape
