// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/contact_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "physics/cloth/contact/pairs/nearest_points.h"

namespace drape {
namespace {

// A direction across the two parts, where they touch.
Eigen::Vector3d AcrossParts(bool of_edges, const PairColumns& x) {
  const Eigen::Vector3d u = of_edges ? x.col(1) - x.col(0) : x.col(2) - x.col(1);
  const Eigen::Vector3d v = x.col(3) - x.col(of_edges ? 2 : 1);
  const Eigen::Vector3d across = u.cross(v);
  return across.norm() > 0.0 ? across.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
}

// How far the parts can move along dx, as a share of it, until the planes through their nearest
// points, which have the normal n, leave only `kept` between vertices of the two.
double ShareUntil(bool of_edges, const PairColumns& x, const PairColumns& dx,
                  const Eigen::Vector3d& n, double kept) {
  const int of_first = of_edges ? 2 : 1;
  double share = std::numeric_limits<double>::infinity();
  for (int i = 0; i < of_first; ++i)
    for (int j = of_first; j < 4; ++j) {
      const double closing = n.dot(dx.col(j) - dx.col(i));
      if (closing > 0.0)
        share = std::min(share, (n.dot(x.col(i) - x.col(j)) - kept) / closing);
    }
  return std::max(0.0, share);
}

}  // namespace

PairColumns GatherPair(const ContactPair& pair, const Eigen::VectorXd& x) {
  PairColumns columns;
  for (int i = 0; i < 4; ++i) columns.col(i) = x.segment<3>(3 * pair.vertex[i]);
  return columns;
}

PairDistance MeasureDistance(bool of_edges, const PairColumns& x) {
  PairDistance distance;
  if (of_edges) {
    const Eigen::Vector2d at = NearestPositions(x.col(0), x.col(1), x.col(2), x.col(3));
    distance.weight << 1.0 - at[0], at[0], at[1] - 1.0, -at[1];
  } else {
    distance.weight << 1.0, -NearestWeights(x.col(0), x.col(1), x.col(2), x.col(3));
  }
  const Eigen::Vector3d offset = x * distance.weight;
  distance.value = offset.norm();
  distance.normal = distance.value > 0.0 ? Eigen::Vector3d(offset / distance.value)
                                         : AcrossParts(of_edges, x);
  return distance;
}

Mollifier MollifyParallel(const PairColumns& edges, double rest_squares) {
  constexpr double kSmall = 1e-3;
  const Eigen::Vector3d u = edges.col(1) - edges.col(0), v = edges.col(3) - edges.col(2);
  const double scale = kSmall * rest_squares, q = u.cross(v).squaredNorm() / scale;
  if (q >= 1.0) return {};
  const Eigen::Vector3d by_u = 2.0 / scale * (v.squaredNorm() * u - u.dot(v) * v);
  const Eigen::Vector3d by_v = 2.0 / scale * (u.squaredNorm() * v - u.dot(v) * u);
  Mollifier mollifier{.value = q * (2.0 - q)};
  mollifier.gradient << -by_u, by_u, -by_v, by_v;
  mollifier.gradient *= 2.0 - 2.0 * q;
  return mollifier;
}

double SafeShare(bool of_edges, const PairColumns& x, const PairColumns& dx, double thickness) {
  constexpr double kKept = 0.1, kEnough = 0.02;  // of the first gap
  constexpr int kMostRounds = 100;
  double share = 0.0, gap = 0.0, kept = 0.0;
  for (int round = 0; round < kMostRounds; ++round) {
    const PairColumns now = x + share * dx;
    const PairDistance distance = MeasureDistance(of_edges, now);
    if (round == 0) {
      gap = distance.value > thickness ? distance.value - thickness : distance.value;
      kept = distance.value - (1.0 - kKept) * gap;
    } else if (distance.value <= kept + kEnough * gap) {
      break;
    }
    share += ShareUntil(of_edges, now, dx, distance.normal, kept);
    if (share >= 1.0) return 1.0;
  }
  return share;
}

}  // namespace drape
