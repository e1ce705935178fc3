// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "physics/cloth/cloth_model.h"

namespace drape {

// What is measured of a cloth that lies on no support: a strip or a plate.
struct StripView {
  double length;       // at rest, from the last held vertex to the far end along x [m]
  double drop, reach;  // of the tip below and beyond the last held vertex [m]
  double chord;        // angle of the tip below the horizontal, seen from there [°]
  double stretch;      // distance of the tip from there by `length`
};
struct UnsupportedView {
  double largest_move;             // of a vertex from rest [m]
  double sag;                      // of the lowest vertex below rest [m]
  std::optional<StripView> strip;  // where the scene holds a half-plane along x
};
// x: positions [m], shape [3V].
UnsupportedView ViewWithoutSupport(const ClothModel& model, const Eigen::VectorXd& x);

}  // namespace drape
