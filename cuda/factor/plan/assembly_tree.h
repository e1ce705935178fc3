// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "cuda/factor/plan/front_plan.h"

namespace drape {

// Pivots and border of a front, as vertices of the mesh.
struct TreeNode {
  std::vector<int> vertices;  // pivots in elimination order
  std::vector<int> border;    // later vertices that their columns of L reach, in that order
  int parent = -1;            // index of a later node; −1 at a root, which has no border
};

// Of the separators: small fronts merged into their parents where that saves time, those over the
// options' limits made chains. Children before parents. Throws InputError as MakeFrontPlan does.
std::vector<TreeNode> MakeAssemblyTree(const BlockPattern& pattern,
                                       const std::vector<Separator>& separators,
                                       const FrontPlanOptions& options);

// Of each vertex in elimination order.
std::vector<int> EliminationPositions(const std::vector<TreeNode>& tree, int num_vertices);

inline int RoundUp8(int n) { return (n + 7) / 8 * 8; }

}  // namespace drape
