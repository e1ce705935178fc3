// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/methods/slivers.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <vector>

#include "physics/util/errors.h"

namespace drape {
namespace {

// Vertices that may move: beyond the support, off the boundary.
std::vector<char> FreeVertices(const Mesh& mesh, double support_radius) {
  constexpr double kRounding = 1e-9;
  std::vector<char> is_free(mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i)
    is_free[i] = mesh.uv.col(i).norm() > support_radius * (1.0 + kRounding);
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (const int i : loop) is_free[i] = false;
  return is_free;
}

}  // namespace

Mesh AddSliverTriangles(const Mesh& mesh, double support_radius, double ratio) {
  CHECK(ratio > 0.0 && ratio <= 1.0) << ratio;
  std::vector<char> is_free = FreeVertices(mesh, support_radius);
  Eigen::Matrix2Xd uv = mesh.uv;
  bool any = false;
  for (const Hinge& hinge : mesh.hinges) {
    const int a = hinge.vertex[0], b = hinge.vertex[1];
    if (!is_free[a] || !is_free[b]) continue;
    any = true;
    const Eigen::Vector2d middle = 0.5 * (uv.col(a) + uv.col(b));
    for (const int i : {a, b}) uv.col(i) = middle + ratio * (uv.col(i) - middle);
    for (const Face& face : mesh.faces) {  // what touches the edge stays where it is
      const int* v = face.vertex;
      if (std::none_of(v, v + 3, [&](int i) { return i == a || i == b; })) continue;
      for (int k = 0; k < 3; ++k) is_free[v[k]] = false;
    }
  }
  if (!any) throw InputError("slivers", "the mesh has no edge between the support and the hem");
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i) x.segment<2>(3 * i) = uv.col(i);
  return BuildMesh(x, uv, ListTriangles(mesh), "slivers");
}

double MinTriangleQuality(const Mesh& mesh) {
  double worst = 1.0;
  for (const Face& face : mesh.faces) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest, (mesh.uv.col(face.vertex[k]) - mesh.uv.col(face.vertex[(k + 1) % 3])).norm());
    worst = std::min(worst, 2.0 * face.area / (longest * longest));
  }
  return worst;
}

}  // namespace drape
