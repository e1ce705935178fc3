// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <tuple>

#include "physics/util/math/host_device.h"

namespace drape {

// The weights of the corners a, b, c at the point of their triangle that is nearest to p
// [Ericson 2005, 5.1.5]. Exactly 0 for corners that an edge or a corner leaves out.
Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c);
// The weights of the nearest points, for host and device.
DRAPE_HD inline Vec3<double> NearestWeights(const Vec3<double>& p, const Vec3<double>& a,
                                            const Vec3<double>& b, const Vec3<double>& c) {
  const Vec3<double> ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = Dot(ab, ap), d2 = Dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = Dot(ab, bp), d4 = Dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  const double d5 = Dot(ab, cp), d6 = Dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4, along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return {0.0, 1.0 - along, along};
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

// The positions s, t in [0, 1] along the segments a–b and c–d of their points nearest to one
// another [Ericson 2005, 5.1.9]; of parallel ones, some such pair.
Eigen::Vector2d NearestPositions(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, const Eigen::Vector3d& d);

// Two parts of a cloth, or of a cloth and of an obstacle, that can touch and have no vertex in
// common: a vertex and a face, or two edges.
struct ContactPair {
  bool of_edges = false;
  std::array<int, 4> vertex = {};  // the vertex and the face's corners, or the edges' ends

  // Device code includes this header as C++17, which has no operator<=>.
  friend bool operator==(const ContactPair& a, const ContactPair& b) {
    return std::tie(a.of_edges, a.vertex) == std::tie(b.of_edges, b.vertex);
  }
  friend bool operator<(const ContactPair& a, const ContactPair& b) {
    return std::tie(a.of_edges, a.vertex) < std::tie(b.of_edges, b.vertex);
  }
};

// Places or moves of the four vertices of a pair [m].
using PairColumns = Eigen::Matrix<double, 3, 4>;
using PairMatrix = Eigen::Matrix<double, 12, 12>;
PairColumns GatherPair(const ContactPair& pair, const Eigen::VectorXd& x);

// The distance between the nearest points of the two parts. Its derivative by the place of vertex i
// is weight_i·normal.
struct PairDistance {
  double value = 0.0;      // [m]
  Eigen::Vector3d normal;  // from the second part to the first, of unit length
  Eigen::Vector4d weight;  // of the vertices: those of the first part add up to 1, the others to −1
};
PairDistance MeasureDistance(bool of_edges, const PairColumns& x);
// Its second derivatives by the places of the vertices [1/m], in the order of their coordinates.
PairMatrix DistanceCurvature(bool of_edges, const PairColumns& x, const PairDistance& distance);

// A factor of the energy of two edges that fades to 0 as they become parallel, where the distance
// is not differentiable [Li 2020, section 5]: q·(2 − q) with q = |u × v|²/(ε·U·V) < 1, ε = 10⁻³,
// else 1. rest_squares: U·V, the product of the squares of their rest lengths [m⁴].
struct Mollifier {
  double value = 1.0;
  PairColumns gradient = PairColumns::Zero();  // by the places of the vertices [1/m]
};
Mollifier MollifyParallel(const PairColumns& edges, double rest_squares);
PairMatrix MollifierCurvature(const PairColumns& edges, double rest_squares);  // [1/m²]

// The share in [0, 1] of the moves dx from x on which the parts keep a tenth of what their distance
// exceeds `thickness` by, or of the distance where it does not. A plane between the nearest points
// separates the parts until the last vertex reaches it, which is how far each round of additive
// continuous collision detection [Li 2021] goes.
double SafeShare(bool of_edges, const PairColumns& x, const PairColumns& dx, double thickness);

}  // namespace drape
