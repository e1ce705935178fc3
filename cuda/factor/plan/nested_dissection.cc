// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/nested_dissection.h"

#include <glog/logging.h>
#include <metis.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include "physics/linalg/symbolic_analysis.h"

namespace drape {
namespace {

constexpr int kDirections = 16;
constexpr double kFractions[] = {0.44, 0.47, 0.5, 0.53, 0.56};  // of the vertices below the line

// Smallest set of vertices that covers the edges between sides 0 and 1: a maximum matching by
// augmenting paths, then König's theorem.
class MinimalCover {
 public:
  MinimalCover(const VertexGraph& graph, const std::vector<char>& side)
      : graph_(graph), side_(side), partner_(side.size(), -1), seen_(side.size(), -1) {}

  std::vector<char> SeparatedSides() {
    const int n = graph_.num_vertices();
    for (int v = 0; v < n; ++v)
      if (side_[v] == 0) Augment(v, v);
    // Each of these searches fails, and what they see is what alternating paths reach.
    for (int v = 0; v < n; ++v)
      if (side_[v] == 0 && partner_[v] < 0) Augment(v, n);
    std::vector<char> result = side_;
    for (int v = 0; v < n; ++v)
      if (side_[v] == 1 ? seen_[v] == n : partner_[v] >= 0 && seen_[partner_[v]] != n)
        result[v] = Cut::kSeparator;
    return result;
  }

 private:
  bool Augment(int v, int search) {
    for (int k = graph_.start[v]; k < graph_.start[v + 1]; ++k) {
      const int w = graph_.neighbour[k];
      if (side_[w] == 0 || seen_[w] == search) continue;
      seen_[w] = search;
      if (partner_[w] >= 0 && !Augment(partner_[w], search)) continue;
      partner_[w] = v;
      partner_[v] = w;
      return true;
    }
    return false;
  }

  const VertexGraph& graph_;
  const std::vector<char>& side_;
  std::vector<int> partner_;  // in the matching
  std::vector<int> seen_;     // the last search that came by
};

// Neighbours in a front then follow each other in its parent's, too: long runs when it is added.
std::vector<int> AlongPrincipalAxis(std::vector<int> vertices, const Eigen::Matrix2Xd& uv) {
  Eigen::Matrix2Xd place = uv(Eigen::all, vertices);
  place.colwise() -= place.rowwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(place * place.transpose());
  const Eigen::Vector2d axis = axes.eigenvectors().col(1);
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](int a, int b) { return axis.dot(uv.col(a)) < axis.dot(uv.col(b)); });
  return vertices;
}

// The component of each vertex. Components are numbered by first appearance.
std::vector<int> ConnectedComponents(const VertexGraph& graph) {
  std::vector<int> component(graph.num_vertices(), -1), stack;
  int count = 0;
  for (int first = 0; first < graph.num_vertices(); ++first) {
    if (component[first] >= 0) continue;
    component[first] = count;
    stack = {first};
    while (!stack.empty()) {
      const int v = stack.back();
      stack.pop_back();
      for (int k = graph.start[v]; k < graph.start[v + 1]; ++k) {
        const int w = graph.neighbour[k];
        if (component[w] >= 0) continue;
        component[w] = count;
        stack.push_back(w);
      }
    }
    ++count;
  }
  return component;
}

std::vector<std::vector<int>> GroupBy(const std::vector<int>& label,
                                      const std::vector<int>& vertices) {
  std::vector<std::vector<int>> groups(*std::max_element(label.begin(), label.end()) + 1);
  for (std::size_t k = 0; k < label.size(); ++k) groups[label[k]].push_back(vertices[k]);
  return groups;
}

// Neighbouring small parts together while they stay below `limit`.
std::vector<std::vector<int>> Packed(const std::vector<std::vector<int>>& parts, int limit) {
  std::vector<std::vector<int>> packed;
  for (const auto& part : parts) {
    if (packed.empty() || static_cast<int>(packed.back().size() + part.size()) > limit)
      packed.emplace_back();
    packed.back().insert(packed.back().end(), part.begin(), part.end());
  }
  return packed;
}

// How many later vertices the column of L of each place in an order reaches.
std::vector<int> CountReached(const BlockPattern& pattern, const std::vector<int>& order,
                              const std::vector<int>& parent) {
  const int n = static_cast<int>(order.size());
  const std::vector<int> place = FindPlaces(order);
  std::vector<int> reached(n, 0), last(n, -1);
  for (int k = 0; k < n; ++k) {
    last[k] = k;
    for (int b = pattern.row_start[order[k]]; b < pattern.row_start[order[k] + 1]; ++b)
      for (int at = place[pattern.column[b]]; at < k && last[at] != k; at = parent[at]) {
        last[at] = k;
        ++reached[at];
      }
  }
  return reached;
}

class Dissector {
 public:
  Dissector(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv, int leaf_vertices)
      : pattern_(pattern), uv_(uv), leaf_(leaf_vertices), local_(pattern.num_vertices(), -1) {}

  std::vector<Separator> Run() {
    std::vector<int> all(pattern_.num_vertices());
    for (int v = 0; v < pattern_.num_vertices(); ++v) all[v] = v;
    if (!all.empty()) Dissect(all);
    return std::move(nodes_);
  }

 private:
  // The roots of what is made of `vertices`.
  std::vector<int> Dissect(const std::vector<int>& vertices) {
    if (static_cast<int>(vertices.size()) <= leaf_) return {Add(vertices)};
    const VertexGraph graph = Subgraph(vertices);
    const auto parts = GroupBy(ConnectedComponents(graph), vertices);
    if (parts.size() > 1) return DissectAll(Packed(parts, leaf_));
    const Cut cut = BestCut(graph, vertices);
    if (!cut.found()) return {Add(vertices)};
    auto sides = GroupBy({cut.side.begin(), cut.side.end()}, vertices);
    CHECK_EQ(sides.size(), 3U) << "a cut of a connected graph has a separator";
    const std::vector<int> separator = std::move(sides[Cut::kSeparator]);
    sides.pop_back();
    const std::vector<int> roots = DissectAll(sides);
    const int node = Add(separator);
    for (const int root : roots) nodes_[root].parent = node;
    return {node};
  }

  std::vector<int> DissectAll(const std::vector<std::vector<int>>& parts) {
    std::vector<int> roots;
    for (const auto& part : parts)
      for (const int root : Dissect(part)) roots.push_back(root);
    return roots;
  }

  Cut BestCut(const VertexGraph& graph, const std::vector<int>& vertices) const {
    Cut metis = MetisCut(graph), straight = StraightCut(graph, uv_(Eigen::all, vertices));
    return straight.score < metis.score ? straight : metis;
  }

  int Add(const std::vector<int>& vertices) {
    nodes_.push_back({AlongPrincipalAxis(vertices, uv_), -1});
    return static_cast<int>(nodes_.size()) - 1;
  }

  VertexGraph Subgraph(const std::vector<int>& vertices) {
    for (std::size_t k = 0; k < vertices.size(); ++k) local_[vertices[k]] = static_cast<int>(k);
    VertexGraph graph;
    graph.start.push_back(0);
    for (const int v : vertices) {
      for (int b = pattern_.row_start[v]; b < pattern_.row_start[v + 1]; ++b)
        if (const int w = pattern_.column[b]; w != v && local_[w] >= 0)
          graph.neighbour.push_back(local_[w]);
      graph.start.push_back(static_cast<int>(graph.neighbour.size()));
    }
    for (const int v : vertices) local_[v] = -1;
    return graph;
  }

  const BlockPattern& pattern_;
  const Eigen::Matrix2Xd& uv_;
  const int leaf_;
  std::vector<int> local_;  // of a vertex in the subgraph that is being made; −1 outside
  std::vector<Separator> nodes_;
};

constexpr int kRuns = 6;
constexpr idx_t kImbalance[] = {30, 150};  // allowed of the sides, in turns [1/1000]

std::vector<char> Separate(std::vector<idx_t>& start, std::vector<idx_t>& neighbour, int run) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = run + 1;
  options[METIS_OPTION_UFACTOR] = kImbalance[run % 2];
  idx_t n = static_cast<idx_t>(start.size()) - 1, separator_size;
  std::vector<idx_t> part(n);
  const std::lock_guard guard(MetisLock());
  CHECK_EQ(METIS_ComputeVertexSeparator(&n, start.data(), neighbour.data(), nullptr, options,
                                        &separator_size, part.data()),
           METIS_OK);
  return {part.begin(), part.end()};
}

}  // namespace

double CutScore(const std::vector<char>& side) {
  double count[3] = {};
  for (const char s : side) ++count[static_cast<int>(s)];
  if (count[0] == 0 || count[1] == 0) return std::numeric_limits<double>::infinity();
  const double larger = std::max(count[0], count[1]) / static_cast<double>(side.size());
  return count[Cut::kSeparator] * (1 + 0.6 * std::max(0.0, larger - 0.5));
}

Cut StraightCut(const VertexGraph& graph, const Eigen::Matrix2Xd& uv) {
  const int n = graph.num_vertices();
  Cut best;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = std::numbers::pi * k / kDirections;
    const Eigen::VectorXd place =
        uv.transpose() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    Eigen::VectorXd sorted = place;
    std::sort(sorted.begin(), sorted.end());
    for (const double fraction : kFractions) {
      const double line = sorted[std::min(n - 1, static_cast<int>(fraction * n))];
      std::vector<char> side(n);
      for (int v = 0; v < n; ++v) side[v] = place[v] >= line;
      side = MinimalCover(graph, side).SeparatedSides();
      if (const double score = CutScore(side); score < best.score) best = {std::move(side), score};
    }
  }
  return best;
}

std::vector<Separator> NestedDissection(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv,
                                        const DissectionOptions& options) {
  CHECK_EQ(uv.cols(), pattern.num_vertices());
  CHECK_GE(options.leaf_vertices, 1);
  return Dissector(pattern, uv, options.leaf_vertices).Run();
}

std::vector<Separator> MakeSeparators(const BlockPattern& pattern, const std::vector<int>& order) {
  const std::vector<int> parent = EliminationTree(pattern, order),
                         reached = CountReached(pattern, order, parent);
  const int n = static_cast<int>(order.size());
  std::vector<int> children(n + 1, 0), node(n, 0);
  for (const int p : parent) ++children[p];
  std::vector<Separator> separators;
  for (int k = 0; k < n; ++k) {
    if (k == 0 || parent[k - 1] != k || children[k] > 1 || reached[k - 1] != reached[k] + 1)
      separators.emplace_back();
    node[k] = static_cast<int>(separators.size()) - 1;
    separators.back().vertices.push_back(order[k]);
  }
  for (int k = 0; k < n; ++k)
    if (parent[k] < n && node[parent[k]] != node[k]) separators[node[k]].parent = node[parent[k]];
  return separators;
}

Cut MetisCut(const VertexGraph& graph) {
  std::vector<idx_t> start(graph.start.begin(), graph.start.end());
  std::vector<idx_t> neighbour(graph.neighbour.begin(), graph.neighbour.end());
  Cut best;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<char> side = Separate(start, neighbour, run);
    if (const double score = CutScore(side); score < best.score) best = {std::move(side), score};
  }
  return best;
}

}  // namespace drape
