// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/blocks/block_matrix.h"

#include <algorithm>
#include <utility>

#include "physics/util/math/simd.h"

namespace drape {
namespace {

template <class Vertices>
void AddClique(const Vertices& vertex, std::vector<std::vector<int>>& neighbours) {
  for (int a : vertex)
    for (int b : vertex) neighbours[a].push_back(b);
}

template <int N>
void AppendBlocks(const BlockPattern& p, const int (&vertex)[N], std::vector<int>& out) {
  for (int a : vertex)
    for (int b : vertex) out.push_back(p.Find(a, b));
}

// Fills what follows from the rows and columns.
void FindMirrors(BlockPattern& p) {
  p.mirror.resize(p.num_blocks());
  for (int i = 0; i < p.num_vertices(); ++i)
    for (int b = p.row_start[i]; b < p.row_start[i + 1]; ++b) p.mirror[b] = p.Find(p.column[b], i);
}

// Computes the three rows of vertex i of y += A·x for V registers of type T from `column` on. The
// sums stay in registers over the whole row of A.
template <class T, int V>
void AddRowProduct(const BlockPattern& p, const BlockMatrix& A, int i, const RowMatrix& x,
                   int column, RowMatrix& y) {
  constexpr int kWidth = kLanes<T>;
  T sum[3][V] = {};
  for (int b = p.row_start[i]; b < p.row_start[i + 1]; ++b) {
    const double *block = A.block(b), *from = &x(3 * p.column[b], column);
    for (int k = 0; k < 3; ++k, from += x.cols())
      for (int v = 0; v < V; ++v) {
        const T value = LoadAs<T>(from + kWidth * v);
        for (int r = 0; r < 3; ++r) sum[r][v] += block[3 * r + k] * value;
      }
  }
  for (int r = 0; r < 3; ++r)
    for (int v = 0; v < V; ++v) {
      double* to = &y(3 * i + r, column + kWidth * v);
      Store(LoadAs<T>(to) + sum[r][v], to);
    }
}

}  // namespace

int BlockPattern::Find(int row, int col) const {
  const auto begin = column.begin() + row_start[row], end = column.begin() + row_start[row + 1];
  const auto it = std::lower_bound(begin, end, col);
  return it != end && *it == col ? static_cast<int>(it - column.begin()) : -1;
}

bool BlockPattern::HasAllBlocks(const std::array<int, 4>& group) const {
  return std::all_of(group.begin(), group.end(), [&](int i) {
    return std::all_of(group.begin(), group.end(), [&](int j) { return Find(i, j) >= 0; });
  });
}

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
  FindMirrors(p);
  for (int i = 0; i < mesh.num_vertices(); ++i) p.diagonal.push_back(p.Find(i, i));
  if (with_faces)
    for (const Face& f : mesh.faces) AppendBlocks(p, f.vertex, p.face_block);
  if (with_hinges)
    for (const Hinge& e : mesh.hinges) AppendBlocks(p, e.vertex, p.hinge_block);
  return p;
}

BlockPattern AddGroups(const BlockPattern& pattern, const std::vector<std::array<int, 4>>& groups) {
  std::vector<std::pair<int, int>> added;
  for (const std::array<int, 4>& group : groups)
    for (const int i : group)
      for (const int j : group)
        if (pattern.Find(i, j) < 0) added.emplace_back(i, j);
  std::sort(added.begin(), added.end());
  added.erase(std::unique(added.begin(), added.end()), added.end());

  BlockPattern wider;
  wider.row_start.push_back(0);
  std::vector<int> place(pattern.num_blocks());  // of each block in the wider pattern
  auto next = added.begin();
  for (int i = 0; i < pattern.num_vertices(); ++i) {
    const auto add_before = [&](int column) {
      for (; next != added.end() && *next < std::pair(i, column); ++next)
        wider.column.push_back(next->second);
    };
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      add_before(pattern.column[b]);
      place[b] = wider.num_blocks();
      wider.column.push_back(pattern.column[b]);
    }
    add_before(pattern.num_vertices());
    wider.row_start.push_back(wider.num_blocks());
  }
  const auto placed = [&](std::vector<int> blocks) {
    for (int& b : blocks) b = place[b];
    return blocks;
  };
  FindMirrors(wider);
  wider.diagonal = placed(pattern.diagonal);
  wider.face_block = placed(pattern.face_block);
  wider.hinge_block = placed(pattern.hinge_block);
  return wider;
}

bool AddSymmetricBlock(const BlockPattern& pattern, int i, int j, const Eigen::Matrix3d& block,
                       BlockMatrix& A) {
  const int here = pattern.Find(i, j);
  if (here < 0) return false;
  A.Add(here, block);
  if (i != j) A.Add(pattern.mirror[here], block.transpose());
  return true;
}

void AddMultiply(const BlockPattern& pattern, const BlockMatrix& A, const RowMatrix& x,
                 RowMatrix& y) {
  const int registers = static_cast<int>(x.cols() / 4), rest = static_cast<int>(x.cols() % 4);
  for (int i = 0; i < pattern.num_vertices(); ++i) {
    ForEachChunk<4>(registers, [&]<int V>(int first) {
      AddRowProduct<Vec4, V>(pattern, A, i, x, 4 * first, y);
    });
    for (int k = 0; k < rest; ++k) AddRowProduct<double, 1>(pattern, A, i, x, 4 * registers + k, y);
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
