// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/mesh/mesh.h"
#include "physics/simulation/textbook.h"

namespace drape {

// Closed forms and quantities of textbooks that only tests compare with.

// The linear material that bends as a beam of rigidity `EI` by width [N·m] where it is free to curl
// across, as in a narrow strip: D·(1 − ν²) = EI [MODEL, M54].
inline MaterialField LinearBeam(double k, double EI, double density) {
  return LinearMaterial(k, EI / (1.0 - kHingePoisson * kHingePoisson), density);
}

// The tables of the same cloth with u and v exchanged by a quarter turn [MODEL, M59].
inline MaterialField TurnedByQuarter(MaterialField material) {
  for (StretchTable& table : material.stretch) {
    std::reverse(table.c + 1, table.c + kStretchRows);  // row 0 has no direction
    for (auto& row : table.c) std::swap(row[0], row[2]);
  }
  for (BendTable& table : material.bend) std::reverse(table.b, table.b + kBendRows);
  return material;
}

inline Eigen::Matrix2d SymmetricCurvature(const Eigen::Vector3d& uu_vv_uv) {
  return (Eigen::Matrix2d() << uu_vv_uv[0], uu_vv_uv[2], uu_vv_uv[2], uu_vv_uv[1]).finished();
}

// Rigidity of a flat mesh relative to the plate rigidity when all hinges are bent to the surface
// with this symmetric curvature [1/m], shape [2, 2]: 2·energy/(D·area) by B = 4·D and W =
// B·l²θ²/(8(A0 + A1)), computed here independently of the force law. It is 1 for curvature about
// one axis and 2(1 + ν) for a dome [MODEL, M54], up to the effect of free edges, which have no
// hinges.
inline double CurvatureRigidity(const Mesh& mesh, const Eigen::Matrix2d& curvature) {
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

// The same for curvature 1 along u of a mesh that is free to curl across and to twist.
inline double BeamRigidity(const Mesh& mesh) {
  Eigen::Matrix3d form;  // of the curvatures uu, vv, uv, by polarisation
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d a = Eigen::Vector3d::Unit(i), b = Eigen::Vector3d::Unit(j);
      form(i, j) = 0.25 * (CurvatureRigidity(mesh, SymmetricCurvature(a + b)) -
                           CurvatureRigidity(mesh, SymmetricCurvature(a - b)));
    }
  return 1.0 / form.inverse()(0, 0);
}

// The deflection of the rim of a stiff disc of radius b that lies clamped on a support of radius
// ratio·b under a small uniform load q: w·D/(q·b⁴), for 0 < ratio < 1 and a plate of Poisson ratio
// nu [Timoshenko 1959], [MODEL, M58]. CHECKs the range.
//
// With b = q = D = 1: w = r⁴/64 + E·r²·ln r + B·ln r + C·r² + const. No shear at the rim gives E;
// no slope at the support and no moment at the rim give B and C.
inline double AnnulusDeflection(double ratio, double nu) {
  CHECK(ratio > 0.0 && ratio < 1.0) << ratio;
  constexpr double kE = -1.0 / 8.0;
  const double a = ratio, log_a = std::log(a);
  const Eigen::Matrix2d of_b_and_c{{1.0 / a, 2.0 * a}, {nu - 1.0, 2.0 * (1.0 + nu)}};
  const Eigen::Vector2d slope_and_moment(a * a * a / 16.0 + kE * a * (2.0 * log_a + 1.0),
                                         (3.0 + nu) / 16.0 + kE * (3.0 + nu));
  const Eigen::Vector2d bc = of_b_and_c.inverse() * -slope_and_moment;
  return (1.0 - std::pow(a, 4)) / 64.0 - kE * a * a * log_a - bc[0] * log_a + bc[1] * (1.0 - a * a);
}

// The plate rigidity D [N·m] that a bend table gives a hardly curved cloth bent along `direction`
// [rad] to the weft [MODEL, M8]: its hinges lie in all directions φ, and each contributes with the
// weight sin⁴(φ − direction).
inline double DirectionalRigidity(const BendTable& table, double direction) {
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

// Mean of x − x_rest [m] over the vertices with the largest u. x [m], shape [3V].
inline Eigen::Vector3d TipMove(const Mesh& mesh, const Eigen::VectorXd& x) {
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
