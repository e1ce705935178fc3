// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace drape {

// Which forces act. A term that is not listed costs nothing: no memory, no loop, no pattern entry.
struct Handles {
  double radius = 0.09;     // vertices with |x_rest| < radius (or on it to rounding) are held [m]
  double stiffness = 1e3;   // spring of each held vertex to its rest position [N/m]
};

struct Scene {
  bool stretch = true;
  bool bend = true;
  std::optional<Eigen::Vector3d> gravity;  // [m/s²]
  std::optional<Handles> handles;
};

// The drape test of BS 5058 / ISO 9073-9: support of radius 9 cm, gravity −9.8 m/s² along z.
inline Scene CusickScene() {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.handles = Handles();
  return scene;
}

}  // namespace drape
