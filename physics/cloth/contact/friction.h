// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace drape {

// Coulomb's friction at one contact in one time step, smoothed and lagged [MODEL, M61]: the normal
// force and the normal are held. What rubs is the point that weights of up to four vertices give.
struct Rub {
  std::array<int, 4> vertex = {};
  Eigen::Vector4d weight = Eigen::Vector4d::UnitX();  // 0 of those that take no part
  double limit = 0.0;                                 // μ·λ, with the normal force λ [N]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of unit length
  Eigen::Vector3d start = Eigen::Vector3d::Zero();    // where the point would be without slip [m]
  // An iterate of Newton's method: the force against the slip by the limit, to first order from the
  // shape before. It lies in the tangent plane and is at most 1 long.
  Eigen::Vector3d share = Eigen::Vector3d::Zero();

  Eigen::Vector3d Point(const Eigen::VectorXd& x) const;
};

// What acts on the point of a rub.
struct RubForce {
  double potential;           // [J]
  Eigen::Vector3d force;      // [N]
  Eigen::Matrix3d stiffness;  // positive semidefinite; −∂force/∂point at the share of it [N/m]
};
// creep: the relative speed above which a contact slides [m/s]; h: the time step [s].
RubForce EvaluateRub(const Rub& rub, const Eigen::Vector3d& point, double creep, double h);
// The share after a move of the point [Chan 1999, eq. 4.5].
Eigen::Vector3d ShareAfter(const Rub& rub, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                           double creep, double h);

}  // namespace drape
