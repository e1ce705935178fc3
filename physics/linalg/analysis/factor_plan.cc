// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/analysis/factor_plan.h"

#include <glog/logging.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "physics/linalg/analysis/cholmod_graph.h"

namespace drape {
namespace {

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
