// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/halve_edges.h"

#include <algorithm>
#include <map>
#include <utility>

namespace drape {

Mesh HalveEdges(const Mesh& mesh) {
  const std::vector<RestEdge> edges = ListEdges(mesh);
  const Eigen::Index old = mesh.num_vertices(), all = old + std::ssize(edges);
  Eigen::VectorXd rest_x(3 * all);
  Eigen::Matrix2Xd uv(2, all);
  rest_x.head(3 * old) = mesh.rest_x;
  uv.leftCols(old) = mesh.uv;
  std::map<std::pair<int, int>, int> midpoints;
  for (const RestEdge& edge : edges) {
    const auto [a, b] = edge.vertex;
    const int middle = static_cast<int>(old + std::ssize(midpoints));
    midpoints.emplace(std::pair(a, b), middle);
    rest_x.segment<3>(3 * middle) =
        0.5 * (mesh.rest_x.segment<3>(3 * a) + mesh.rest_x.segment<3>(3 * b));
    uv.col(middle) = 0.5 * (mesh.uv.col(a) + mesh.uv.col(b));
  }
  std::vector<std::array<int, 3>> triangles;
  for (const auto& [a, b, c] : ListTriangles(mesh)) {
    const auto between = [&](int i, int j) { return midpoints.at(std::minmax(i, j)); };
    const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
    triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return BuildMesh(rest_x, uv, triangles, "a mesh of half the edges");
}

}  // namespace drape
