// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/analysis/elimination_order.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "physics/linalg/analysis/cholmod_graph.h"

namespace drape {
namespace {

// An adapted order may cost this multiple of the operations of a new dissection.
constexpr double kMostOperations = 1.25;

// Two vertices of a new block, neither of which is the other's ancestor in the elimination tree,
// and the place of their lowest common one: V if they have none.
struct Conflict {
  int one, other, ancestor;
};

std::vector<Conflict> FindConflicts(const std::vector<int>& order, const BlockPattern& pattern,
                                    const BlockPattern& other) {
  const std::vector<int> place = FindPlaces(order), parent = EliminationTree(pattern, order);
  std::vector<Conflict> conflicts;
  for (int i = 0; i < other.num_vertices(); ++i)
    for (int b = other.row_start[i]; b < other.row_start[i + 1]; ++b) {
      const int j = other.column[b];
      if (j <= i || pattern.Find(i, j) >= 0) continue;
      int low = std::min(place[i], place[j]), high = std::max(place[i], place[j]);
      const int later = high;
      while (low != high) {
        if (low > high) std::swap(low, high);
        low = parent[low];
      }
      if (low != later) conflicts.push_back({i, j, low});
    }
  return conflicts;
}

// The places before which vertices move: of each conflict at least one.
std::map<int, int> CoverConflicts(const std::vector<Conflict>& conflicts) {
  std::map<int, std::vector<int>> of_vertex;
  for (int k = 0; k < static_cast<int>(conflicts.size()); ++k)
    for (const int i : {conflicts[k].one, conflicts[k].other}) of_vertex[i].push_back(k);
  std::map<int, int> open;                // conflicts that are not covered, by vertex
  std::set<std::pair<int, int>> by_most;  // the same, negative, with the vertex
  for (const auto& [i, list] : of_vertex) {
    open[i] = static_cast<int>(list.size());
    by_most.insert({-open[i], i});
  }
  std::vector<bool> covered(conflicts.size(), false);
  std::map<int, int> moved;
  while (!by_most.empty() && by_most.begin()->first < 0) {
    const int i = by_most.begin()->second;
    for (const int k : of_vertex[i]) {
      if (covered[k]) continue;
      covered[k] = true;
      moved[i] = std::max(moved[i], conflicts[k].ancestor);
      for (const int end : {conflicts[k].one, conflicts[k].other}) {
        by_most.erase({-open[end], end});
        by_most.insert({-(--open[end]), end});
      }
    }
  }
  return moved;
}

EliminationOrder Postordered(const BlockPattern& pattern, std::vector<int> vertex) {
  CholmodGraph graph(pattern);
  graph.AnalysePostordered(vertex);
  return {std::move(vertex), graph.operations(), graph.operations()};
}

}  // namespace

EliminationOrder DissectVertices(const BlockPattern& pattern) {
  return Postordered(pattern, CholmodGraph(pattern).Dissect());
}

EliminationOrder AdaptOrder(const EliminationOrder& order, const BlockPattern& pattern,
                            const BlockPattern& other) {
  const std::map<int, int> moved = CoverConflicts(FindConflicts(order.vertex, pattern, other));
  std::vector<std::tuple<int, bool, int>> keys;  // the place, whether it is its own, the one before
  for (int k = 0; k < static_cast<int>(order.vertex.size()); ++k) {
    const auto found = moved.find(order.vertex[k]);
    keys.emplace_back(found == moved.end() ? k : found->second, found == moved.end(), k);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<int> vertex;
  for (const auto& [place, is_own, before] : keys) vertex.push_back(order.vertex[before]);
  EliminationOrder adapted = Postordered(other, std::move(vertex));
  if (adapted.operations > kMostOperations * order.dissected_operations)
    return DissectVertices(other);
  adapted.dissected_operations = order.dissected_operations;
  return adapted;
}

std::vector<int> FindPlaces(const std::vector<int>& order) {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  return place;
}

std::vector<int> EliminationTree(const BlockPattern& pattern, const std::vector<int>& order) {
  const int n = pattern.num_vertices();
  const std::vector<int> place = FindPlaces(order);
  std::vector<int> parent(n, n), ancestor(n, n);
  for (int k = 0; k < n; ++k)
    for (int b = pattern.row_start[order[k]]; b < pattern.row_start[order[k] + 1]; ++b) {
      int at = place[pattern.column[b]];
      if (at >= k) continue;
      while (ancestor[at] != n && ancestor[at] != k) at = std::exchange(ancestor[at], k);
      if (ancestor[at] != n) continue;
      ancestor[at] = k;
      parent[at] = k;
    }
  return parent;
}

}  // namespace drape
