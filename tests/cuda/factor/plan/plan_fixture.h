// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "cuda/factor/plan/front_plan.h"
#include "tests/physics/cloth_fixture.h"

// Meshes and graphs of the tests of plans.
namespace drape::test {

inline Mesh Disc(int vertices) {
  DiscOptions options;
  options.target_vertices = vertices;
  return MakeDisc(options);
}

inline std::shared_ptr<const ClothModel> Cloth(const Mesh& mesh, bool stretch, bool bend) {
  Scene scene = CusickScene();
  scene.stretch = stretch;
  scene.bend = bend;
  return std::make_shared<ClothModel>(mesh, scene, MakeLaw("smooth"));
}

// The pattern with `neighbours` (ascending, each of a pair in both lists, oneself included).
inline BlockPattern BlockPatternFrom(const std::vector<std::vector<int>>& neighbours) {
  BlockPattern p;
  p.row_start.push_back(0);
  for (int v = 0; v < static_cast<int>(neighbours.size()); ++v) {
    for (const int w : neighbours[v]) {
      if (w == v) p.diagonal.push_back(p.num_blocks());
      p.column.push_back(w);
    }
    p.row_start.push_back(p.num_blocks());
  }
  return p;
}

// `joined(v, w)` for v ≠ w.
template <class Joined>
BlockPattern PatternWhere(int vertices, Joined&& joined) {
  std::vector<std::vector<int>> neighbours(vertices);
  for (int v = 0; v < vertices; ++v)
    for (int w = 0; w < vertices; ++w)
      if (v == w || joined(v, w)) neighbours[v].push_back(w);
  return BlockPatternFrom(neighbours);
}

struct PlacedPattern {
  BlockPattern pattern;
  Eigen::Matrix2Xd uv;
};

// Twice the pattern of a disc with hinges, in the same place and not joined.
inline PlacedPattern TwoDiscs(int vertices) {
  const Mesh mesh = Disc(vertices);
  const BlockPattern one = MakeBlockPattern(mesh, true, true);
  std::vector<std::vector<int>> neighbours(2 * vertices);
  for (int v = 0; v < 2 * vertices; ++v)
    for (int b = one.row_start[v % vertices]; b < one.row_start[v % vertices + 1]; ++b)
      neighbours[v].push_back(one.column[b] + v / vertices * vertices);
  Eigen::Matrix2Xd uv(2, 2 * vertices);
  uv << mesh.uv, mesh.uv;
  return {BlockPatternFrom(neighbours), uv};
}

// Patterns that are no mesh's: no edge at all, and all edges (METIS returns an empty part).
inline PlacedPattern Isolated(int vertices) {
  return {PatternWhere(vertices, [](int, int) { return false; }),
          Eigen::Matrix2Xd::Random(2, vertices)};
}
inline PlacedPattern Complete(int vertices) {
  return {PatternWhere(vertices, [](int, int) { return true; }),
          Eigen::Matrix2Xd::Random(2, vertices)};
}

inline Mesh TwoFaces() {
  Eigen::Matrix2Xd uv(2, 4);
  uv << 0.0, 0.1, 0.1, 0.0,  //
      0.0, 0.0, 0.1, 0.1;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(12);
  for (int v = 0; v < 4; ++v) x.segment<2>(3 * v) = uv.col(v);
  return BuildMesh(x, uv, {{0, 1, 2}, {0, 2, 3}}, "two faces");
}

}  // namespace drape::test
