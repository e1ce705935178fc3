// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/linalg/analysis/factor_plan.h"
#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// The pattern of a factor of the 3V unknowns, three of a vertex one after the other.
struct SymbolicAnalysis {
  LowerTriangle lower;  // its sources are places in the block matrix
  SupernodalPattern pattern;
};
// By CHOLMOD. order: of elimination, [V]. Throws std::runtime_error where the factor has more than
// 2³¹ numbers, and std::bad_alloc.
SymbolicAnalysis AnalyseSymbolically(const BlockPattern& pattern, const std::vector<int>& order);

}  // namespace drape
