// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "cuda/factor/plan/front_plan.h"
#include "physics/cloth/scene.h"

namespace drape {

// A piece of a workspace that is in use in the levels first … last.
struct UpdateBlock {
  std::int64_t size;
  int first, last;
};

struct UpdateSpace {
  std::vector<std::int64_t> offset;  // of each block
  std::int64_t size = 0;
};

// First fit: each block, by first level and then large ones first, where it fits below the others
// that are in use.
UpdateSpace PackUpdates(const std::vector<UpdateBlock>& blocks);

// Which elements add to which block of a matrix or to which vertex, in a fixed order: sums by
// gather need no atomics and are the same in each run. Meshes are numbered in elimination order
// here (Renumber).
struct GatherList {
  std::vector<int> start;  // [N + 1]
  std::vector<int> item;   // packed Contributions: faces first, each kind by ascending element
};

// Corner `row` of an element adds to a vertex; corners (row, column) to a block.
struct Contribution {
  int element;
  bool hinge;
  int row, column;  // corners 0..3

  int Pack() const { return element << 5 | static_cast<int>(hinge) << 4 | row << 2 | column; }
};

// To each of plan.entries; `scene` says whether faces and hinges act.
GatherList GatherEntries(const FrontPlan& plan, const Mesh& mesh, const Scene& scene);
// To each vertex (column = row).
GatherList GatherVertices(const Mesh& mesh, const Scene& scene);
// Targets of a list by falling number of contributions within each `chunk` of them, so that the
// threads of a warp, one for each target, have as much to do: a vertex has twenty, the corners
// across a hinge one.
std::vector<int> OrderByWork(const GatherList& list, int chunk);
// The entry of each vertex with itself, [V]: to it alone contact with an obstacle adds.
std::vector<int> DiagonalEntries(const FrontPlan& plan);

}  // namespace drape
