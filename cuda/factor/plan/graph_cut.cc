// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/graph_cut.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace drape {
namespace {

constexpr int kDirections = 16;
constexpr double kFractions[] = {0.44, 0.47, 0.5, 0.53, 0.56};  // of the vertices below the line

// Smallest set of vertices that covers the edges between sides 0 and 1: a maximum matching by
// augmenting paths, then König's theorem.
class MinimalCover {
 public:
  MinimalCover(const Graph& graph, const std::vector<char>& side)
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

  const Graph& graph_;
  const std::vector<char>& side_;
  std::vector<int> partner_;  // in the matching
  std::vector<int> seen_;     // the last search that came by
};

}  // namespace

double CutScore(const std::vector<char>& side) {
  double count[3] = {};
  for (const char s : side) ++count[static_cast<int>(s)];
  if (count[0] == 0 || count[1] == 0) return std::numeric_limits<double>::infinity();
  const double larger = std::max(count[0], count[1]) / static_cast<double>(side.size());
  return count[Cut::kSeparator] * (1 + 0.6 * std::max(0.0, larger - 0.5));
}

Cut StraightCut(const Graph& graph, const Eigen::Matrix2Xd& uv) {
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

}  // namespace drape
