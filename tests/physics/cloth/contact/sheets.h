// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/mesh_spec.h"

namespace drape::test {

constexpr double kGravity = 9.8;  // [m/s²]
constexpr double kDensity = 0.2;  // [kg/m²], of the sheets

// The gap at which the contact carries `pressure`, that of −κ·b'(gap) = pressure [m].
inline double RestingGap(const Contact& contact, double pressure) {
  double low = 0.0, high = contact.range;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (-contact.stiffness * EvaluateBarrier(middle, contact.range).slope > pressure ? low : high) =
        middle;
  }
  return low;
}

// A square sheet whose side from x = −side/2 to side/2 has so many edges.
inline Mesh Square(double side, int along) {
  Mesh mesh = MakeStrip(side, side, along, static_cast<int>(std::lround(1.155 * along)));
  for (Eigen::Index i = 0; i < mesh.rest_x.size(); i += 3) mesh.rest_x[i] -= 0.5 * side;
  return mesh;
}

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
