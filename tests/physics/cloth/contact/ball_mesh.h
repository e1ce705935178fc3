// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace drape::test {

struct BallMesh {
  Eigen::Matrix3Xd x;
  std::vector<std::array<int, 3>> triangles;
};

// A closed mesh of a ball about the origin: an octahedron whose triangles are divided into four
// `divisions` times.
inline BallMesh MakeBall(double radius, int divisions) {
  std::vector<Eigen::Vector3d> points = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                         {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  std::vector<std::array<int, 3>> triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2},
                                               {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (int division = 0; division < divisions; ++division) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [it, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<int>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const std::array<int, 3>& part :
           {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(part);
    }
    triangles = std::move(finer);
  }
  BallMesh ball{Eigen::Matrix3Xd(3, points.size()), std::move(triangles)};
  for (std::size_t i = 0; i < points.size(); ++i)
    ball.x.col(static_cast<Eigen::Index>(i)) = radius * points[i];
  return ball;
}

}  // namespace drape::test
