// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/friction.h"

#include <algorithm>

namespace drape {

Eigen::Vector3d Rub::Point(const Eigen::VectorXd& x) const {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) point += weight[i] * x.segment<3>(3 * vertex[i]);
  return point;
}

namespace {

// The force is −limit·slip/length, with its derivative by the slip.
struct Slip {
  Eigen::Matrix3d along;      // onto the tangent plane
  Eigen::Vector3d slip;       // [m]
  Eigen::Vector3d direction;  // of unit length; 0 of none
  double speed;               // [m/s]
  double length;              // |slip|, but not below half of the way of creep [m]
  double slope;               // ∂length/∂|slip|
};

Slip MeasureSlip(const Rub& rub, const Eigen::Vector3d& point, double creep, double h) {
  Slip s;
  s.along = Eigen::Matrix3d::Identity() - rub.normal * rub.normal.transpose();
  s.slip = s.along * (point - rub.start);
  const double way = s.slip.norm();
  s.direction = s.slip / std::max(way, 1e-300);
  s.speed = way / h;
  const double most = s.speed < creep ? 2.0 - s.speed / creep : 1.0;
  s.length = s.speed < creep ? creep * h / most : way;
  s.slope = 1.0 / (most * most);
  return s;
}

}  // namespace

RubForce EvaluateRub(const Rub& rub, const Eigen::Vector3d& point, double creep, double h) {
  const Slip s = MeasureSlip(rub, point, creep, h);
  const double potential = s.speed < creep
                               ? s.speed * s.speed / creep * (1.0 - s.speed / (3.0 * creep))
                               : s.speed - creep / 3.0;
  const Eigen::Matrix3d turned = rub.share * s.direction.transpose();
  return {.potential = rub.limit * h * potential,
          .force = -rub.limit / s.length * s.slip,
          .stiffness =
              rub.limit / s.length * (s.along - 0.5 * s.slope * (turned + turned.transpose()))};
}

Eigen::Vector3d ShareAfter(const Rub& rub, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                           double creep, double h) {
  const Slip s = MeasureSlip(rub, from, creep, h);
  const Eigen::Vector3d move = s.along * (to - from);
  const Eigen::Vector3d share =
      (s.slip + move - s.slope * s.direction.dot(move) * rub.share) / s.length;
  return share / std::max(1.0, share.norm());
}

}  // namespace drape
