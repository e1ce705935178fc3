// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/analysis/symbolic_analysis.h"

#include <algorithm>
#include <utility>

#include "physics/linalg/analysis/cholmod_graph.h"
#include "physics/linalg/analysis/elimination_order.h"

namespace drape {
namespace {

// The lower triangle of the matrix in an order of elimination.
LowerTriangle MakeLowerTriangle(const BlockPattern& p, const std::vector<int>& order) {
  const std::vector<int> place = FindPlaces(order);
  LowerTriangle lower;
  lower.column_start.push_back(0);
  std::vector<std::pair<int, int>> below;  // the place of a vertex and its block
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    // Row j of the symmetric pattern lists the row blocks of column j.
    const int j = order[k];
    below.clear();
    for (int b = p.row_start[j]; b < p.row_start[j + 1]; ++b)
      if (place[p.column[b]] >= k) below.emplace_back(place[p.column[b]], b);
    std::sort(below.begin(), below.end());
    for (int c = 0; c < 3; ++c) {
      for (const auto& [row, block] : below)
        for (int r = row == k ? c : 0; r < 3; ++r) {
          lower.row.push_back(3 * row + r);
          lower.source.push_back(9 * block + 3 * c + r);
        }
      lower.column_start.push_back(static_cast<int>(lower.row.size()));
    }
  }
  return lower;
}

}  // namespace

SymbolicAnalysis AnalyseSymbolically(const BlockPattern& pattern, const std::vector<int>& order) {
  LowerTriangle lower = MakeLowerTriangle(pattern, order);
  CholmodGraph graph(lower.column_start, lower.row);
  const cholmod_factor& factor = graph.AnalyseAsIs();
  const auto ints = [](const void* p, std::size_t count) {
    return std::vector<int>(static_cast<const int*>(p), static_cast<const int*>(p) + count);
  };
  SupernodalPattern supernodes{ints(factor.super, factor.nsuper + 1),
                               ints(factor.pi, factor.nsuper + 1),
                               ints(factor.px, factor.nsuper + 1), ints(factor.s, factor.ssize)};
  return {std::move(lower), std::move(supernodes)};
}

}  // namespace drape
