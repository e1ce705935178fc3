// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/friction.h"

#include <algorithm>

namespace drape {

Eigen::Vector3d Rub::Point(const Eigen::VectorXd& x) const {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) point += weight[i] * x.segment<3>(3 * vertex[i]);
  return point;
}

RubForce EvaluateRub(const Rub& rub, const Eigen::Vector3d& point, double creep, double h) {
  const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - rub.normal * rub.normal.transpose();
  const Eigen::Vector3d slip = along * (point - rub.start);
  const double speed = slip.norm() / h;
  if (speed < creep) {
    const double slope = (2.0 - speed / creep) / (creep * h);  // of the force by the slip
    const Eigen::Vector3d direction = slip / std::max(slip.norm(), 1e-300);
    return {.potential = rub.limit * h * speed * speed / creep * (1.0 - speed / (3.0 * creep)),
            .force = -rub.limit * slope * slip,
            .stiffness = rub.limit * (slope * along - speed / (creep * creep * h) * direction *
                                                          direction.transpose())};
  }
  const Eigen::Vector3d direction = slip / slip.norm();
  return {.potential = rub.limit * h * (speed - creep / 3.0),
          .force = -rub.limit * direction,
          .stiffness = rub.limit / slip.norm() * (along - direction * direction.transpose())};
}

}  // namespace drape
