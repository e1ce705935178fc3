// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "physics/mesh/mesh.h"

namespace drape {

// A flat disc of a centre vertex and rings × sectors vertices on circles. The vertex of ring i ≥ 1
// and sector j is 1 + (i−1)·sectors + j. It is built here, so that these tests need no mesh
// builder.
inline Mesh MakeDisc(int rings, int sectors, double radius) {
  Mesh mesh;
  mesh.uv = Eigen::Matrix2Xd::Zero(2, 1 + rings * sectors);
  const auto index = [&](int ring, int j) {
    return ring == 0 ? 0 : 1 + (ring - 1) * sectors + (j % sectors);
  };
  for (int ring = 1; ring <= rings; ++ring) {
    for (int j = 0; j < sectors; ++j) {
      const double r = radius * ring / rings, angle = 2 * M_PI * j / sectors;
      mesh.uv.col(index(ring, j)) << r * std::cos(angle), r * std::sin(angle);
    }
  }
  const auto add_face = [&](int a, int b, int c) { mesh.faces.push_back({{a, b, c}, 0, {}}); };
  for (int ring = 1; ring <= rings; ++ring) {
    for (int j = 0; j < sectors; ++j) {
      add_face(index(ring - 1, j), index(ring, j), index(ring, j + 1));
      if (ring > 1) add_face(index(ring - 1, j), index(ring, j + 1), index(ring - 1, j + 1));
    }
  }
  mesh.rest_x = Eigen::VectorXd::Zero(3 * mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i) mesh.rest_x.segment<2>(3 * i) = mesh.uv.col(i);
  std::map<std::pair<int, int>, std::pair<int, int>> first_use;  // edge → (face, opposite vertex)
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int* v = mesh.faces[f].vertex;
      const int a = v[k], b = v[(k + 1) % 3], opposite = v[(k + 2) % 3];
      const auto [it, fresh] = first_use.try_emplace(std::minmax(a, b), f, opposite);
      if (fresh) continue;
      const auto [face0, opposite0] = it->second;
      mesh.hinges.push_back({{b, a, opposite0, opposite}, {face0, f}, 0, 0, 0});
    }
  }
  mesh.boundary_loops.resize(1);
  for (int j = 0; j < sectors; ++j) mesh.boundary_loops[0].push_back(index(rings, j));
  return mesh;
}

// Positions of a disc of radius 15 cm: r·(1 + amplitude·cos(folds·θ))·shrink towards the hem,
// turned about the axis by twist·sin(folds·θ), and lower with increasing r.
struct DrapeShape {
  int folds = 6;
  double amplitude = 0.12;
  double shrink = 0.75;
  double twist = 0.0;  // [rad]
};
inline Eigen::VectorXd Deform(const Mesh& mesh, const DrapeShape& shape) {
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const double r = mesh.uv.col(i).norm(), angle = std::atan2(mesh.uv(1, i), mesh.uv(0, i));
    const double s = r / 0.15;
    const double radius =
        r * (1 + s * (shape.shrink - 1) + s * shape.amplitude * std::cos(shape.folds * angle));
    const double turned = angle + s * shape.twist * std::sin(shape.folds * angle);
    x.segment<3>(3 * i) << radius * std::cos(turned), radius * std::sin(turned),
        -0.1 * s * s - 0.02 * s * std::sin(shape.folds * angle);
  }
  return x;
}

// Standard normal numbers, repeatable by the seed.
inline Eigen::VectorXd RandomVector(int size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(generator); });
}

}  // namespace drape
