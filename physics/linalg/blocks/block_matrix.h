// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

// Several vectors over the 3V degrees of freedom, one in each column, shape [3V, m]. Rows are
// contiguous.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The pattern of the 3×3 blocks of a matrix over vertices that can be non-zero (compressed rows,
// symmetric, diagonal included), and the blocks to which each element adds. It is built once for a
// mesh.
struct BlockPattern {
  std::vector<int> row_start;    // [V + 1]
  std::vector<int> column;       // [N], ascending in each row
  std::vector<int> mirror;       // [N] index of block (j, i) of block (i, j)
  std::vector<int> diagonal;     // [V] index of block (i, i)
  std::vector<int> face_block;   // [F, 3, 3]
  std::vector<int> hinge_block;  // [E, 4, 4]

  int num_vertices() const { return static_cast<int>(row_start.size()) - 1; }
  int num_blocks() const { return static_cast<int>(column.size()); }
  int Find(int row, int col) const;  // the index of a block of the pattern; −1 of another
  bool HasAllBlocks(const std::array<int, 4>& group) const;  // the blocks between these vertices
};

BlockPattern MakeBlockPattern(const Mesh& mesh, bool with_faces, bool with_hinges);
// Returns the pattern with all blocks between the vertices of each group.
BlockPattern AddGroups(const BlockPattern& pattern, const std::vector<std::array<int, 4>>& groups);

// The values on a pattern, as row-major 3×3 blocks.
struct BlockMatrix {
  std::vector<double> value;  // [N, 3, 3]

  explicit BlockMatrix(const BlockPattern& pattern) : value(9 * pattern.num_blocks()) {}
  double* block(int b) { return value.data() + 9 * b; }
  const double* block(int b) const { return value.data() + 9 * b; }
  void SetZero() { std::fill(value.begin(), value.end(), 0.0); }
  void AddScaledIdentity(int b, double s) {
    for (int r = 0; r < 3; ++r) block(b)[4 * r] += s;
  }
  void Add(int b, const Eigen::Matrix3d& added) {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(block(b)) += added;
  }
};

// Adds a block at (i, j) and, if these differ, its transpose at (j, i). Returns false where the
// pattern has no such block.
[[nodiscard]] bool AddSymmetricBlock(const BlockPattern& pattern, int i, int j,
                                     const Eigen::Matrix3d& block, BlockMatrix& A);

// y += A·x and y += Aᵀ·x, shapes [3V, m].
void AddMultiply(const BlockPattern& pattern, const BlockMatrix& A, const RowMatrix& x,
                 RowMatrix& y);
void AddTransposeMultiply(const BlockPattern& pattern, const BlockMatrix& A, const RowMatrix& x,
                          RowMatrix& y);

}  // namespace drape
