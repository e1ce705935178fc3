// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/textbook.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace drape {
namespace {

Eigen::Matrix2d Symmetric(const Eigen::Vector3d& uu_vv_uv) {
  return (Eigen::Matrix2d() << uu_vv_uv[0], uu_vv_uv[2], uu_vv_uv[2], uu_vv_uv[1]).finished();
}

// An elastica under its own weight, integrated from its free tip towards the clamp: τ = Γ^⅓·σ with
// σ = 1 − s, slope'' = −τ·cos(slope). The integration stops where the slope is level.
struct Elastica {
  double gamma, chord;
};

Elastica FromTip(double tip_slope) {
  constexpr double kStep = 2e-3;
  using Vector = Eigen::Vector4d;  // slope, slope', reach, drop
  const auto rate = [](double tau, const Vector& y) {
    return Vector(y[1], -tau * std::cos(y[0]), std::cos(y[0]), std::sin(y[0]));
  };
  Vector y(tip_slope, 0.0, 0.0, 0.0);
  for (double tau = 0.0;; tau += kStep) {
    const Vector a = rate(tau, y), b = rate(tau + kStep / 2, y + kStep / 2 * a),
                 c = rate(tau + kStep / 2, y + kStep / 2 * b), d = rate(tau + kStep, y + kStep * c);
    const Vector next = y + kStep / 6 * (a + 2 * b + 2 * c + d);
    if (next[0] > 0.0) {
      y = next;
      continue;
    }
    const double share = y[0] / (y[0] - next[0]);  // of the last step, interpolated linearly
    const Vector end = y + share * (next - y);
    return {std::pow(tau + share * kStep, 3), std::atan2(end[3], end[2])};
  }
}

}  // namespace

MaterialField LinearMaterial(double k, double D, double density) {
  MaterialField material;
  material.density = density;
  StretchTable stretch;
  for (auto& row : stretch.c) {
    row[0] = row[2] = k / kMembranePerEntry;
    row[3] = 0.5 * k / kMembranePerEntry;
  }
  BendTable bend;
  for (auto& row : bend.b) std::fill(std::begin(row), std::end(row), kBendPerRigidity * D);
  material.stretch = {stretch};
  material.bend = {bend};
  return material;
}

MaterialField LinearBeam(double k, double EI, double density) {
  return LinearMaterial(k, EI / (1.0 - kHingePoisson * kHingePoisson), density);
}

MaterialField TurnedByQuarter(MaterialField material) {
  for (StretchTable& table : material.stretch) {
    std::reverse(table.c + 1, table.c + kStretchRows);  // row 0 has no direction
    for (auto& row : table.c) std::swap(row[0], row[2]);
  }
  for (BendTable& table : material.bend) std::reverse(table.b, table.b + kBendRows);
  return material;
}

double CurvatureRigidity(const Mesh& mesh, const Eigen::Matrix2d& curvature) {
  constexpr double kSmall = 1e-4;  // scale of the curvature, so that angles are small
  const auto point = [&](int i) {
    const Eigen::Vector2d u = mesh.uv.col(i);
    return Eigen::Vector3d(u.x(), u.y(), kSmall / 2 * u.dot(curvature * u));
  };
  double energy = 0.0, area = 0.0;
  for (const Face& face : mesh.faces) area += face.area;
  for (const Hinge& hinge : mesh.hinges) {
    const Eigen::Vector3d a = point(hinge.vertex[0]), b = point(hinge.vertex[1]);
    const Eigen::Vector3d n0 = (b - a).cross(point(hinge.vertex[2]) - a).normalized();
    const Eigen::Vector3d n1 = (point(hinge.vertex[3]) - a).cross(b - a).normalized();
    const double theta = std::asin(n0.cross(n1).norm());
    energy += kBendPerRigidity * hinge.rest_length * hinge.rest_length * theta * theta /
              (8 * hinge.rest_area);
  }
  return energy / (area * kSmall * kSmall / 2);
}

double BeamRigidity(const Mesh& mesh) {
  Eigen::Matrix3d form;  // of the curvatures uu, vv, uv, by polarisation
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d a = Eigen::Vector3d::Unit(i), b = Eigen::Vector3d::Unit(j);
      form(i, j) = 0.25 * (CurvatureRigidity(mesh, Symmetric(a + b)) -
                           CurvatureRigidity(mesh, Symmetric(a - b)));
    }
  return 1.0 / form.inverse()(0, 0);
}

// With b = q = D = 1: w = r⁴/64 + E·r²·ln r + B·ln r + C·r² + const. No shear at the rim gives E;
// no slope at the support and no moment at the rim give B and C.
double AnnulusDeflection(double ratio, double nu) {
  CHECK(ratio > 0.0 && ratio < 1.0) << ratio;
  constexpr double kE = -1.0 / 8.0;
  const double a = ratio, log_a = std::log(a);
  const Eigen::Matrix2d of_b_and_c{{1.0 / a, 2.0 * a}, {nu - 1.0, 2.0 * (1.0 + nu)}};
  const Eigen::Vector2d slope_and_moment(a * a * a / 16.0 + kE * a * (2.0 * log_a + 1.0),
                                         (3.0 + nu) / 16.0 + kE * (3.0 + nu));
  const Eigen::Vector2d bc = of_b_and_c.inverse() * -slope_and_moment;
  return (1.0 - std::pow(a, 4)) / 64.0 - kE * a * a * log_a - bc[0] * log_a + bc[1] * (1.0 - a * a);
}

double HeavyElasticaGamma(double chord) {
  CHECK(chord > 0.0 && chord < M_PI / 2) << chord;
  double low = 0.0, high = M_PI / 2;  // slopes of the tip
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (FromTip(middle).chord < chord ? low : high) = middle;
  }
  return FromTip(0.5 * (low + high)).gamma;
}

double DirectionalRigidity(const BendTable& table, double direction) {
  constexpr int kDirections = 360;
  double sum = 0.0, weights = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double edge = M_PI * i / kDirections;
    const double row = std::min(edge, M_PI - edge) * 4.0 / M_PI;  // 0 … 2 of the table
    const int below = std::min(static_cast<int>(row), kBendRows - 2);
    const double B =
        table.b[below][0] + (row - below) * (table.b[below + 1][0] - table.b[below][0]);
    const double weight = std::pow(std::sin(edge - direction), 4);
    sum += weight * B;
    weights += weight;
  }
  return sum / weights / kBendPerRigidity;
}

Eigen::Vector3d TipMove(const Mesh& mesh, const Eigen::VectorXd& x) {
  const double end = mesh.uv.row(0).maxCoeff();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    if (mesh.uv(0, i) < end - 1e-9) continue;
    sum += x.segment<3>(3 * i) - mesh.rest_x.segment<3>(3 * i);
    ++count;
  }
  return sum / count;
}

}  // namespace drape
