// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/contact_pair.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace drape {
namespace {

constexpr double kParallel = 1e-3;  // ε of the mollifier

// The derivative of |u × v|² by the places of the vertices of two edges u and v.
PairColumns CrossGradient(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  const Eigen::Vector3d by_u = 2.0 * (v.squaredNorm() * u - u.dot(v) * v),
                        by_v = 2.0 * (u.squaredNorm() * v - u.dot(v) * u);
  PairColumns gradient;
  gradient << -by_u, by_u, -by_v, by_v;
  return gradient;
}

// A direction across the two parts, where they touch.
Eigen::Vector3d AcrossParts(bool of_edges, const PairColumns& x) {
  const Eigen::Vector3d u = of_edges ? x.col(1) - x.col(0) : x.col(2) - x.col(1);
  const Eigen::Vector3d v = x.col(3) - x.col(of_edges ? 2 : 1);
  const Eigen::Vector3d across = u.cross(v);
  return across.norm() > 0.0 ? across.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
}

// The changes of the weights, one a column, that keep the nearest points on their features: on a
// corner, an edge or a face.
Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, 2> FreeChanges(bool of_edges,
                                                              const Eigen::Vector4d& weight) {
  Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, 2> changes(4, 0);
  const std::array<int, 3> begin = {0, of_edges ? 2 : 1, 4};
  for (int part = 0; part < 2; ++part) {
    int first = -1;
    for (int i = begin[part]; i < begin[part + 1]; ++i) {
      if (weight[i] == 0.0) continue;
      if (first >= 0) {
        changes.conservativeResize(4, changes.cols() + 1);
        changes.rightCols<1>() = Eigen::Vector4d::Unit(i) - Eigen::Vector4d::Unit(first);
      } else {
        first = i;
      }
    }
  }
  return changes;
}

// Each entry times the identity.
PairMatrix Spread(const Eigen::Matrix4d& by_vertices) {
  PairMatrix spread;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      spread.block<3, 3>(3 * i, 3 * j) = by_vertices(i, j) * Eigen::Matrix3d::Identity();
  return spread;
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
      if (closing > 0.0) share = std::min(share, (n.dot(x.col(i) - x.col(j)) - kept) / closing);
    }
  return std::max(0.0, share);
}

}  // namespace

Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto plain = [](const Eigen::Vector3d& v) { return Vec3<double>{v.x(), v.y(), v.z()}; };
  const Vec3<double> weights = NearestWeights(plain(p), plain(a), plain(b), plain(c));
  return {weights.x, weights.y, weights.z};
}

Eigen::Vector2d NearestPositions(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  const double uw = u.dot(w), vw = v.dot(w), determinant = uu * vv - uv * uv;
  const auto share = [](double number, double of) {
    return of > 0.0 ? std::clamp(number / of, 0.0, 1.0) : 0.0;
  };
  const double s = determinant > 1e-14 * uu * vv ? share(uv * vw - vv * uw, determinant) : 0.0;
  const double t = s * uv + vw;
  if (t <= 0.0) return {share(-uw, uu), 0.0};
  if (t >= vv) return {share(uv - uw, uu), 1.0};
  return {s, t / vv};
}

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
  distance.normal =
      distance.value > 0.0 ? Eigen::Vector3d(offset / distance.value) : AcrossParts(of_edges, x);
  return distance;
}

// The nearest points are those at which D = ½|o|², o = x·w, is least by the weights w. Their
// changes c_p lower the second derivatives of D with w held, which gives those of the distance.
PairMatrix DistanceCurvature(bool of_edges, const PairColumns& x, const PairDistance& distance) {
  const Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, 2> changes =
      FreeChanges(of_edges, distance.weight);
  const Eigen::Vector3d offset = distance.value * distance.normal;
  PairMatrix by_places = Spread(distance.weight * distance.weight.transpose());
  if (changes.cols() > 0) {
    const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 2> slides = x * changes;
    Eigen::Matrix<double, Eigen::Dynamic, 12, 0, 2, 12> mixed(changes.cols(), 12);
    for (Eigen::Index p = 0; p < changes.cols(); ++p)
      for (int i = 0; i < 4; ++i)
        mixed.block<1, 3>(p, 3 * i) =
            (distance.weight[i] * slides.col(p) + changes(i, p) * offset).transpose();
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2, 2> by_weights =
        slides.transpose() * slides;
    by_places -= mixed.transpose() * by_weights.inverse() * mixed;
  }
  const Eigen::Vector<double, 12> gradient =
      (distance.normal * distance.weight.transpose()).reshaped();
  return (by_places - gradient * gradient.transpose()) / distance.value;
}

Mollifier MollifyParallel(const PairColumns& edges, double rest_squares) {
  const Eigen::Vector3d u = edges.col(1) - edges.col(0), v = edges.col(3) - edges.col(2);
  const double scale = kParallel * rest_squares, q = u.cross(v).squaredNorm() / scale;
  if (q >= 1.0) return {};
  return {.value = q * (2.0 - q), .gradient = (2.0 - 2.0 * q) / scale * CrossGradient(u, v)};
}

PairMatrix MollifierCurvature(const PairColumns& edges, double rest_squares) {
  const Eigen::Vector3d u = edges.col(1) - edges.col(0), v = edges.col(3) - edges.col(2);
  const double scale = kParallel * rest_squares, q = u.cross(v).squaredNorm() / scale;
  if (q >= 1.0) return PairMatrix::Zero();
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d uu = v.squaredNorm() * one - v * v.transpose(),
                        vv = u.squaredNorm() * one - u * u.transpose(),
                        uv = 2.0 * u * v.transpose() - v * u.transpose() - u.dot(v) * one;
  PairMatrix of_q;
  of_q << uu, -uu, uv, -uv, -uu, uu, -uv, uv, uv.transpose(), -uv.transpose(), vv, -vv,
      -uv.transpose(), uv.transpose(), -vv, vv;
  const PairColumns by_q = CrossGradient(u, v);
  return (2.0 - 2.0 * q) * 2.0 / scale * of_q -
         2.0 / (scale * scale) * by_q.reshaped() * by_q.reshaped().transpose();
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
