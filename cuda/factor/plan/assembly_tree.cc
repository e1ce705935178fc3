// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/assembly_tree.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "physics/util/errors.h"

namespace drape {
namespace {

using Tree = std::vector<TreeNode>;

void ComputeBorders(const BlockPattern& pattern, Tree& tree) {
  const std::vector<int> position = EliminationPositions(tree, pattern.num_vertices());
  std::vector<int> seen(pattern.num_vertices(), -1);
  for (TreeNode& node : tree) node.border.clear();
  // A node's border holds, until its turn comes, what its children hand up.
  for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
    TreeNode& node = tree[i];
    std::vector<int> reached;
    const int last = position[node.vertices.back()];
    const auto reach = [&](int v) {
      if (position[v] <= last || seen[v] == i) return;
      seen[v] = i;
      reached.push_back(v);
    };
    for (const int v : node.border) reach(v);
    for (const int v : node.vertices)
      for (int b = pattern.row_start[v]; b < pattern.row_start[v + 1]; ++b)
        reach(pattern.column[b]);
    std::sort(reached.begin(), reached.end(),
              [&](int a, int b) { return position[a] < position[b]; });
    node.border = std::move(reached);
    if (node.border.empty()) node.parent = -1;
    if (node.parent < 0) continue;
    std::vector<int>& up = tree[node.parent].border;
    up.insert(up.end(), node.border.begin(), node.border.end());
  }
}

// Operations of a front, and its fixed cost.
double FrontCost(std::size_t pivot_vertices, std::size_t border_vertices) {
  const double p = 3.0 * pivot_vertices, q = 3.0 * border_vertices;
  return p * p * p / 3 + p * p * q + p * q * q + 30000;
}

bool MergePays(const TreeNode& child, const TreeNode& parent, int max_vertices) {
  const std::size_t merged = child.vertices.size() + parent.vertices.size();
  return static_cast<int>(merged) <= max_vertices &&
         FrontCost(merged, parent.border.size()) <
             FrontCost(child.vertices.size(), child.border.size()) +
                 FrontCost(parent.vertices.size(), parent.border.size());
}

// Drops nodes without vertices; their children's parents have been moved on.
Tree WithoutEmptyNodes(const Tree& tree) {
  std::vector<int> index(tree.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < tree.size(); ++i)
    if (!tree[i].vertices.empty()) index[i] = count++;
  Tree kept;
  for (const TreeNode& node : tree) {
    if (node.vertices.empty()) continue;
    kept.push_back(node);
    if (node.parent >= 0) kept.back().parent = index[node.parent];
  }
  return kept;
}

// A merged front has the parent's border: the child's lies within the parent's front.
Tree Amalgamated(Tree tree, int max_vertices) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (TreeNode& node : tree) {
      if (node.vertices.empty() || node.parent < 0) continue;
      while (tree[node.parent].vertices.empty()) node.parent = tree[node.parent].parent;
      TreeNode& parent = tree[node.parent];
      if (!MergePays(node, parent, max_vertices)) continue;
      parent.vertices.insert(parent.vertices.begin(), node.vertices.begin(), node.vertices.end());
      node.vertices.clear();
      changed = true;
    }
  }
  for (TreeNode& node : tree)
    while (node.parent >= 0 && tree[node.parent].vertices.empty())
      node.parent = tree[node.parent].parent;
  return WithoutEmptyNodes(tree);
}

std::int64_t PanelBytes(int pivot_vertices, int border_vertices) {
  const std::int64_t p = RoundUp8(3 * pivot_vertices), q = RoundUp8(3 * border_vertices);
  return (p + q + 8) * (p + 4) * static_cast<std::int64_t>(sizeof(double));
}

// Piece j of `count` begins at pivot vertex PieceStart.
int PieceStart(int vertices, int j, int count) {
  return static_cast<int>(static_cast<std::int64_t>(vertices) * j / count);
}

bool PiecesFit(const TreeNode& node, int count, int max_vertices, int shared_bytes) {
  const int n = static_cast<int>(node.vertices.size()), q = static_cast<int>(node.border.size());
  for (int j = 0; j < count; ++j) {
    const int end = PieceStart(n, j + 1, count), size = end - PieceStart(n, j, count);
    if (size > max_vertices || PanelBytes(size, n - end + q) > shared_bytes) return false;
  }
  return true;
}

int NumPieces(const TreeNode& node, int max_vertices, int shared_bytes) {
  const int n = static_cast<int>(node.vertices.size());
  for (int count = 1; count <= n; ++count)
    if (PiecesFit(node, count, max_vertices, shared_bytes)) return count;
  throw InputError("GPU factorisation",
                   "the mesh is too large: a front of " + std::to_string(n + node.border.size()) +
                       " vertices does not fit in " + std::to_string(shared_bytes) +
                       " bytes of shared memory");
}

Tree SplitIntoChains(const Tree& tree, int max_vertices, int shared_bytes) {
  Tree split;
  std::vector<int> first(tree.size()), last(tree.size());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const std::vector<int>& all = tree[i].vertices;
    const int n = static_cast<int>(all.size());
    const int count = NumPieces(tree[i], max_vertices, shared_bytes);
    first[i] = static_cast<int>(split.size());
    last[i] = first[i] + count - 1;
    for (int j = 0; j < count; ++j)
      split.push_back(
          {{all.begin() + PieceStart(n, j, count), all.begin() + PieceStart(n, j + 1, count)},
           {},
           first[i] + j + 1});
  }
  for (std::size_t i = 0; i < tree.size(); ++i)
    split[last[i]].parent = tree[i].parent < 0 ? -1 : first[tree[i].parent];
  return split;
}

}  // namespace

std::vector<int> EliminationPositions(const std::vector<TreeNode>& tree, int num_vertices) {
  std::vector<int> position(num_vertices, -1);
  int count = 0;
  for (const TreeNode& node : tree)
    for (const int v : node.vertices) position[v] = count++;
  CHECK_EQ(count, num_vertices);
  return position;
}

std::vector<TreeNode> MakeAssemblyTree(const BlockPattern& pattern,
                                       const std::vector<Separator>& separators,
                                       const FrontPlanOptions& options) {
  const int max_vertices = options.max_pivots / 3;
  Tree tree;
  for (const Separator& s : separators) tree.push_back({s.vertices, {}, s.parent});
  ComputeBorders(pattern, tree);
  tree = SplitIntoChains(Amalgamated(std::move(tree), max_vertices), max_vertices,
                         options.shared_bytes);
  ComputeBorders(pattern, tree);
  return tree;
}

}  // namespace drape
