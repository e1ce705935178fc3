// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "physics/mesh/mesh.h"

namespace drape::test {

// Several cloths as one mesh. Their vertices follow one another.
inline Mesh Together(const std::vector<Mesh>& sheets) {
  int vertices = 0;
  for (const Mesh& sheet : sheets) vertices += sheet.num_vertices();
  Eigen::VectorXd x(3 * vertices);
  Eigen::Matrix2Xd uv(2, vertices);
  std::vector<std::array<int, 3>> triangles;
  int begin = 0;
  for (const Mesh& sheet : sheets) {
    x.segment(3 * begin, sheet.rest_x.size()) = sheet.rest_x;
    uv.middleCols(begin, sheet.num_vertices()) = sheet.uv;
    for (std::array<int, 3> triangle : ListTriangles(sheet)) {
      for (int& i : triangle) i += begin;
      triangles.push_back(triangle);
    }
    begin += sheet.num_vertices();
  }
  return BuildMesh(x, uv, triangles, "sheets");
}

}  // namespace drape::test
