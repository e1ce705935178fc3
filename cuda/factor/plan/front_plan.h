// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "cuda/factor/plan/nested_dissection.h"
#include "physics/cloth/scene.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Symbolic plan of a multifrontal Cholesky factorisation A = L·Lᵀ [Duff 1983; Liu 1992] that
// all rollouts of a mesh share. Degrees of freedom are numbered in elimination order: vertex v has
// 3·position[v] … + 2. A front is a dense matrix over its p pivots and q border rows:
//   [F11    ]      panel [F11; F21] of A's entries and of the children's updates → [L11; L21],
//   [F21 F22]      update F22 − L21·L21ᵀ → to the parent.
// p and q are rounded up to multiples of 8 (tensor-core tiles); pivots of the padding are 1.

// Plain data: the kernels read the same struct.
struct Front {
  int pivots, border;            // p, q, multiples of 8
  int true_pivots, true_border;  // multiples of 3
  int first_dof;                 // of its pivots
  int border_start;              // [border] in FrontPlan::border_dof
  int entry_start, entry_end;    // its blocks of A in FrontPlan::entries
  int child_start, child_end;    // in FrontPlan::children
  int source_start;              // [children, p + q] in FrontPlan::source
  int vector_offset;             // of its border vector in a solve's workspace [doubles]
  std::int64_t factor_offset;    // of its panel, row-major [p + q, p] [doubles]
  std::int64_t update_offset;    // of its update, row-major [q + 1, q]: row q is the right-hand
                                 // side's; lower triangle only; space is used again once the parent
                                 // is done (levels run one after the other) [doubles]
};

// A child's border rows seen from its parent's front (rows 0..p−1 pivots, then p + border row).
struct FrontChild {
  int front;      // index of the child
  int row_start;  // [p + q of the parent] in FrontPlan::child_row: row of the child's border
};

// A 3×3 block (row, column) of A's lower triangle in elimination order, in the panel of the front
// that eliminates `column`.
struct FrontEntry {
  int row, column;              // vertices' positions, row ≥ column
  int panel_row, panel_column;  // of the block's first number
};

struct FrontPlan {
  std::vector<int> position;  // [V] of vertex v in elimination order
  std::vector<int> vertex;    // [V] its inverse
  std::vector<Front> fronts;  // children before parents
  std::vector<FrontChild> children;
  std::vector<FrontEntry> entries;
  std::vector<int> border_dof;          // elimination-order dofs; −1 in the padding
  std::vector<std::int16_t> child_row;  // −1 where the child has none
  std::vector<int> source;              // the same as places in a solve's workspace, front by front
  std::vector<int> level_start;         // [levels + 1] in level_front
  std::vector<int> level_front;  // fronts by level, leaves first, large ones first in a level
  std::int64_t factor_size = 0, update_size = 0;  // [doubles]
  int vector_size = 0;                            // [doubles]
  double flops = 0.0;                             // of a factorisation, padding included

  int num_vertices() const { return static_cast<int>(position.size()); }
  int num_levels() const { return static_cast<int>(level_start.size()) - 1; }
};

struct FrontPlanOptions {
  DissectionOptions dissection = {};
  int max_pivots = 63;  // unknowns a front; larger separators become chains of fronts
  // A front and its right-hand side, [p + q + 8, p + 4] doubles, fit in these.
  int shared_bytes = 232448;
};

// Throws InputError when the panel of one vertex does not fit.
FrontPlan MakeFrontPlan(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv,
                        const FrontPlanOptions& options);
// From a dissection of the pattern.
FrontPlan MakeFrontPlan(const BlockPattern& pattern, const std::vector<Separator>& separators,
                        const FrontPlanOptions& options);

// The mesh with its vertices in elimination order; faces and hinges keep their own order and
// corners.
Mesh Renumber(const Mesh& mesh, const FrontPlan& plan);

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
