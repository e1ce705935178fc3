// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

namespace drape::test {

struct BallMesh {
  Eigen::Matrix3Xd x;
  std::vector<std::array<int, 3>> triangles;
};

// A closed mesh of a ball about the origin with `rows` rows of triangles from pole to pole.
inline BallMesh MakeBall(double radius, int rows) {
  const int columns = 2 * rows, rings = rows - 1;
  BallMesh ball;
  ball.x.resize(3, rings * columns + 2);
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < columns; ++j) {
      const double polar = M_PI * (i + 1) / rows, turn = 2 * M_PI * j / columns;
      ball.x.col(i * columns + j) =
          radius * Eigen::Vector3d(std::sin(polar) * std::cos(turn),
                                   std::sin(polar) * std::sin(turn), std::cos(polar));
    }
  const int top = rings * columns, bottom = top + 1;
  ball.x.col(top) = radius * Eigen::Vector3d::UnitZ();
  ball.x.col(bottom) = -radius * Eigen::Vector3d::UnitZ();
  for (int j = 0; j < columns; ++j) {
    const int next = (j + 1) % columns;
    ball.triangles.push_back({top, j, next});
    for (int i = 0; i + 1 < rings; ++i) {
      const int a = i * columns + j, b = i * columns + next;
      ball.triangles.push_back({a, a + columns, b + columns});
      ball.triangles.push_back({a, b + columns, b});
    }
    ball.triangles.push_back({(rings - 1) * columns + j, bottom, (rings - 1) * columns + next});
  }
  return ball;
}

}  // namespace drape::test
