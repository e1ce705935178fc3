// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <variant>

namespace drape {

// Regions select vertices by their rest position; bounds are included to rounding [m] [MODEL, M28].
struct DiscRegion {
  double radius = 0.09;  // |x_rest| ≤ radius
};
struct RingRegion {
  double inner = 0.0;  // inner ≤ |x_rest| ≤ outer
  double outer = std::numeric_limits<double>::infinity();
};
struct HalfPlaneRegion {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // unit length
  double offset = 0.0;                                // normal·x_rest ≤ offset
};
using Region = std::variant<DiscRegion, RingRegion, HalfPlaneRegion>;
bool Contains(const Region& region, const Eigen::Vector3d& rest_x);

// The forces that act [MODEL, M28]. A term that is not listed takes neither memory nor time.
struct Handles {
  Region region = DiscRegion();  // the vertices that are held
  double stiffness = 1e3;        // spring of each held vertex to its rest position [N/m]
};

// A dead load on the part of the hem that lies in the region, distributed evenly by length.
struct EdgeLoad {
  Region region;
  Eigen::Vector3d force;  // total [N]
};

struct Scene {
  bool stretch = true;
  bool bend = true;
  std::optional<Eigen::Vector3d> gravity;  // [m/s²]
  std::optional<Handles> handles;
  std::optional<EdgeLoad> load;
};

// The drape test [BS 5058], [ISO 9073-9], [MODEL, M29]: a support of radius 9 cm and gravity −9.8
// m/s² along z.
Scene CusickScene();
// The radius of the disc on which the cloth lies [m]; std::nullopt when the scene has no such
// support.
std::optional<double> SupportRadius(const Scene& scene);

// Scenes of a strip as MakeStrip places it, u = x from 0 to its length [m].

// The cantilever test [ASTM D1388]: the strip is held where x ≤ clamp [m], and the rest of it bends
// down along −z under gravity [m/s²].
Scene CantileverScene(double clamp, double gravity);
// The strip is held at x = 0 and hangs along +x under gravity [m/s²].
Scene HangingStripScene(double gravity);
// The strip is held at x = 0 and pulled along +x at x = length [m] by `force` [N], without gravity.
Scene UniaxialScene(double length, double force);

// A disc held where |x| ≥ radius [m], under gravity [m/s²] along −z. Two rings of held vertices
// clamp its edge; one ring leaves the edge free to rotate.
Scene ClampedDiscScene(double radius, double gravity);

}  // namespace drape
