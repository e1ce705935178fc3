// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace drape::test {

// The surface of a solid, counter-clockwise seen from outside.
struct ClosedMesh {
  Eigen::Matrix3Xd x;
  std::vector<std::array<int, 3>> triangles;
};

// A closed mesh of a ball about the origin: an octahedron whose triangles are divided into four
// `divisions` times.
inline ClosedMesh MakeBall(double radius, int divisions) {
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
  ClosedMesh ball{Eigen::Matrix3Xd(3, points.size()), std::move(triangles)};
  for (std::size_t i = 0; i < points.size(); ++i)
    ball.x.col(static_cast<Eigen::Index>(i)) = radius * points[i];
  return ball;
}

// A prism on its side: a ridge along x of that length, with its middle in the origin, over a base
// of the same length at z = −height.
inline ClosedMesh MakeWedge(double length, double width, double height) {
  const double x = 0.5 * length, y = 0.5 * width;
  ClosedMesh wedge{
      Eigen::Matrix3Xd(3, 6),
      {{0, 3, 2}, {1, 4, 5}, {0, 4, 1}, {0, 2, 4}, {0, 5, 3}, {0, 1, 5}, {2, 5, 4}, {2, 3, 5}}};
  wedge.x << -x, x, -x, -x, x, x, 0, 0, -y, y, -y, y, 0, 0, -height, -height, -height, -height;
  return wedge;
}

// A prism along y from 0 to that length. section: x and z of its corners, counter-clockwise where x
// is to the right and z upwards; caps: triangles of it.
inline ClosedMesh MakePrism(const std::vector<Eigen::Vector2d>& section,
                            const std::vector<std::array<int, 3>>& caps, double length) {
  const int n = static_cast<int>(section.size());
  ClosedMesh prism{Eigen::Matrix3Xd(3, 2 * n), caps};
  for (const auto& [a, b, c] : caps) prism.triangles.push_back({a + n, c + n, b + n});
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    prism.x.col(i) << section[i].x(), 0.0, section[i].y();
    prism.x.col(i + n) << section[i].x(), length, section[i].y();
    prism.triangles.push_back({j, i, i + n});
    prism.triangles.push_back({j, i + n, j + n});
  }
  return prism;
}

// A cube from the origin to (size, size, size).
inline ClosedMesh MakeCube(double size) {
  return MakePrism({{0, 0}, {size, 0}, {size, size}, {0, size}}, {{0, 1, 2}, {0, 2, 3}}, size);
}

// A stair of two treads of that width and height, which meet at a right angle in a concave edge
// along y at x = z = size.
inline ClosedMesh MakeStair(double size, double length) {
  const double s = size;
  return MakePrism({{0, 0}, {2 * s, 0}, {2 * s, s}, {s, s}, {s, 2 * s}, {0, 2 * s}},
                   {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, length);
}

// A ring whose section is a circle of radius `thin` about a circle of radius `wide` around z.
inline ClosedMesh MakeRing(double wide, double thin, int around, int across) {
  ClosedMesh ring{Eigen::Matrix3Xd(3, around * across), {}};
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double angle = 2 * M_PI * i / around, section = 2 * M_PI * j / across;
      const double r = wide + thin * std::cos(section);
      ring.x.col(at(i, j)) << r * std::cos(angle), r * std::sin(angle), thin * std::sin(section);
      ring.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      ring.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return ring;
}

}  // namespace drape::test
