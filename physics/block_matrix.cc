// SPDX-License-Identifier: Apache-2.0
#include "physics/block_matrix.h"

#include <algorithm>

namespace drape {
namespace {

template <int N>
void AddClique(const int (&vertex)[N], std::vector<std::vector<int>>& neighbours) {
  for (int a : vertex)
    for (int b : vertex) neighbours[a].push_back(b);
}

int FindBlock(const BlockPattern& p, int row, int column) {
  const auto begin = p.column.begin();
  const auto it = std::lower_bound(begin + p.row_start[row], begin + p.row_start[row + 1], column);
  return static_cast<int>(it - begin);
}

template <int N>
void AppendBlocks(const BlockPattern& p, const int (&vertex)[N], std::vector<int>& out) {
  for (int a : vertex)
    for (int b : vertex) out.push_back(FindBlock(p, a, b));
}

}  // namespace

BlockPattern MakeBlockPattern(const Mesh& mesh, bool with_faces, bool with_hinges) {
  std::vector<std::vector<int>> neighbours(mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i) neighbours[i].push_back(i);
  if (with_faces)
    for (const Face& f : mesh.faces) AddClique(f.vertex, neighbours);
  if (with_hinges)
    for (const Hinge& e : mesh.hinges) AddClique(e.vertex, neighbours);

  BlockPattern p;
  p.row_start.push_back(0);
  for (auto& row : neighbours) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    p.column.insert(p.column.end(), row.begin(), row.end());
    p.row_start.push_back(static_cast<int>(p.column.size()));
  }
  for (int i = 0; i < mesh.num_vertices(); ++i) p.diagonal.push_back(FindBlock(p, i, i));
  if (with_faces)
    for (const Face& f : mesh.faces) AppendBlocks(p, f.vertex, p.face_block);
  if (with_hinges)
    for (const Hinge& e : mesh.hinges) AppendBlocks(p, e.vertex, p.hinge_block);
  return p;
}

void AddMultiply(const BlockPattern& pattern, const BlockMatrix& A, const RowMatrix& x, RowMatrix& y) {
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(A.block(b));
      y.middleRows<3>(3 * i).noalias() += block.lazyProduct(x.middleRows<3>(3 * pattern.column[b]));
    }
}

void AddTransposeMultiply(const BlockPattern& pattern, const BlockMatrix& A, const RowMatrix& x,
                          RowMatrix& y) {
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(A.block(b));
      y.middleRows<3>(3 * pattern.column[b]).noalias() +=
          block.transpose().lazyProduct(x.middleRows<3>(3 * i));
    }
}

}  // namespace drape
