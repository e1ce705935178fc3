// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/symbolic_analysis.h"

#include <cholmod.h>
#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace drape {
namespace {

// A graph that CHOLMOD orders and analyses, with CHOLMOD's workspace. All throw std::bad_alloc.
class CholmodGraph {
 public:
  // The graph of the vertices of a pattern.
  explicit CholmodGraph(const BlockPattern& pattern) {
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

  // The graph of the lower triangle of a matrix.
  explicit CholmodGraph(const LowerTriangle& lower) {
    Start(lower.column_start.size() - 1, lower.row.size());
    std::copy(lower.column_start.begin(), lower.column_start.end(), static_cast<int*>(graph_->p));
    std::copy(lower.row.begin(), lower.row.end(), static_cast<int*>(graph_->i));
  }

  CholmodGraph(const CholmodGraph&) = delete;
  CholmodGraph& operator=(const CholmodGraph&) = delete;

  ~CholmodGraph() {
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_sparse(&graph_, &common_);
    cholmod_finish(&common_);
  }

  // Nested dissection by METIS [George 1973].
  std::vector<int> Dissect() {
    std::vector<int> order(graph_->nrow);
    const std::lock_guard guard(MetisLock());
    Require(cholmod_metis(graph_, nullptr, 0, 1, order.data(), &common_) != 0);
    return order;
  }

  // Analyses a supernodal factorisation in the order given, which is brought into a postorder of
  // the elimination tree, or in the order of the numbers (null). The result is the graph's. Throws
  // std::runtime_error where the factor has more than 2³¹ numbers.
  const cholmod_factor& Analyse(std::vector<int>* order) {
    common_.method[0].ordering = order == nullptr ? CHOLMOD_NATURAL : CHOLMOD_GIVEN;
    common_.postorder = order != nullptr;
    cholmod_free_factor(&factor_, &common_);
    factor_ =
        cholmod_analyze_p(graph_, order == nullptr ? nullptr : order->data(), nullptr, 0, &common_);
    Require(factor_ != nullptr);
    if (order != nullptr)
      std::copy_n(static_cast<const int*>(factor_->Perm), order->size(), order->begin());
    return *factor_;
  }

  // Operations of a factorisation, after an analysis.
  double operations() const { return common_.fl; }

 private:
  void Start(std::size_t nodes, std::size_t numbers) {
    CHECK(cholmod_start(&common_));
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.print = 0;
    common_.nmethods = 1;
    graph_ = cholmod_allocate_sparse(nodes, nodes, numbers, 1, 1, -1, CHOLMOD_PATTERN, &common_);
    Require(graph_ != nullptr);
  }

  // A mesh can be too large for CHOLMOD, or for the memory.
  void Require(bool succeeded) const {
    if (succeeded) return;
    if (common_.status == CHOLMOD_TOO_LARGE)
      throw std::runtime_error("the mesh is too large: its factor has more than 2^31 numbers");
    throw std::bad_alloc();
  }

  cholmod_common common_{};
  cholmod_sparse* graph_ = nullptr;
  cholmod_factor* factor_ = nullptr;
};

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
  graph.Analyse(&vertex);
  return {std::move(vertex), graph.operations(), graph.operations()};
}

void PlanTree(const SupernodalPattern& p, FactorPlan& plan) {
  const int supernodes = p.num_supernodes();
  std::vector<int> supernode_of(p.first_column.back());
  for (int s = 0; s < supernodes; ++s)
    std::fill(supernode_of.begin() + p.first_column[s],
              supernode_of.begin() + p.first_column[s + 1], s);
  plan.parent.assign(supernodes, -1);
  plan.first_child.assign(supernodes + 1, 0);
  for (int s = 0; s < supernodes; ++s)
    if (p.num_below(s) > 0) {
      plan.parent[s] = supernode_of[p.row[p.first_row[s] + p.width(s)]];
      ++plan.first_child[plan.parent[s] + 1];
    }
  for (int s = 0; s < supernodes; ++s) plan.first_child[s + 1] += plan.first_child[s];
  plan.child.resize(plan.first_child.back());
  std::vector<int> next(plan.first_child.begin(), plan.first_child.end() - 1);
  for (int s = 0; s < supernodes; ++s)
    if (plan.parent[s] >= 0) plan.child[next[plan.parent[s]]++] = s;
}

// The rows of s below its own, as rows of its parent's front.
void AppendRuns(const SupernodalPattern& p, int s, int parent, std::vector<RowRun>& runs) {
  const int* row = p.row.data() + p.first_row[s] + p.width(s);
  const int* of_parent = p.row.data() + p.first_row[parent];
  const std::size_t first = runs.size();
  for (int i = 0, place = 0; i < p.num_below(s); ++i, ++place) {
    while (place < p.num_rows(parent) && of_parent[place] != row[i]) ++place;
    CHECK_LT(place, p.num_rows(parent));
    if (runs.size() > first && runs.back().to + runs.back().length == place)
      ++runs.back().length;
    else
      runs.push_back({i, place, 1});
  }
}

void PlanEntries(const SupernodalPattern& p, const LowerTriangle& lower, FactorPlan& plan) {
  std::vector<int> panel_row(p.first_column.back());
  for (int s = 0; s < p.num_supernodes(); ++s) {
    plan.first_entry.push_back(static_cast<int>(plan.entry.size()));
    for (int i = 0; i < p.num_rows(s); ++i) panel_row[p.row[p.first_row[s] + i]] = i;
    const int stride = UpdateMatrix::Padded(p.num_rows(s));
    for (int j = p.first_column[s]; j < p.first_column[s + 1]; ++j)
      for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
        const int i = panel_row[lower.row[k]];
        CHECK(p.row[p.first_row[s] + i] == lower.row[k]) << "outside the pattern";
        plan.entry.push_back({(j - p.first_column[s]) * stride + i, lower.source[k]});
      }
  }
  plan.first_entry.push_back(static_cast<int>(plan.entry.size()));
}

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

FactorPlan MakeFactorPlan(const SupernodalPattern& pattern, const LowerTriangle& lower) {
  FactorPlan plan;
  PlanTree(pattern, plan);
  for (int s = 0; s < pattern.num_supernodes(); ++s) {
    plan.first_run.push_back(static_cast<int>(plan.run.size()));
    if (plan.parent[s] >= 0) AppendRuns(pattern, s, plan.parent[s], plan.run);
    double flops = 0.0;
    for (int rows = pattern.num_rows(s); rows > pattern.num_below(s); --rows)
      flops += static_cast<double>(rows) * rows;
    const double below = pattern.num_below(s);
    plan.flops += flops;
    // Measured: a number that is passed costs as much as some ten flops, a front a microsecond.
    plan.work.push_back(flops + 5.0 * below * below + 2e4);
  }
  plan.first_run.push_back(static_cast<int>(plan.run.size()));
  PlanEntries(pattern, lower, plan);
  return plan;
}

std::vector<std::ptrdiff_t> PlacePassed(const FactorPlan& plan,
                                        const std::vector<std::ptrdiff_t>& numbers, int first,
                                        int last, std::size_t* size) {
  std::vector<std::ptrdiff_t> place;
  std::map<std::ptrdiff_t, std::ptrdiff_t> taken;  // begin → end
  std::ptrdiff_t most = 0;
  for (int s = first; s <= last; ++s) {
    std::ptrdiff_t begin = 0;  // of the first gap that is large enough
    for (const auto& [from, to] : taken) {
      if (from - begin >= numbers[s]) break;
      begin = to;
    }
    if (numbers[s] > 0 && plan.parent[s] >= 0) taken[begin] = begin + numbers[s];
    place.push_back(begin);
    most = std::max(most, begin + numbers[s]);
    for (int c = plan.first_child[s]; c < plan.first_child[s + 1]; ++c)
      if (plan.child[c] >= first) taken.erase(place[plan.child[c] - first]);
  }
  *size = static_cast<std::size_t>(most);
  return place;
}

SymbolicAnalysis AnalyseSymbolically(const BlockPattern& pattern, const std::vector<int>& order) {
  LowerTriangle lower = MakeLowerTriangle(pattern, order);
  CholmodGraph graph(lower);
  const cholmod_factor& factor = graph.Analyse(nullptr);
  const auto ints = [](const void* p, std::size_t count) {
    return std::vector<int>(static_cast<const int*>(p), static_cast<const int*>(p) + count);
  };
  SupernodalPattern supernodes{ints(factor.super, factor.nsuper + 1),
                               ints(factor.pi, factor.nsuper + 1),
                               ints(factor.px, factor.nsuper + 1), ints(factor.s, factor.ssize)};
  return {std::move(lower), std::move(supernodes)};
}

}  // namespace drape
