// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <variant>

namespace drape {

// Vertices by their rest position, bounds included to rounding [m].
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

// Which forces act. A term that is not listed costs nothing: no memory, no loop, no pattern entry.
struct Handles {
  Region region = DiscRegion();  // its vertices are held
  double stiffness = 1e3;        // spring of each held vertex to its rest position [N/m]
};

// A dead load on the part of the hem that lies in the region, evenly by length.
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

// The drape test of BS 5058 / ISO 9073-9: support of radius 9 cm, gravity −9.8 m/s² along z.
Scene CusickScene();
// Radius of the disc on which the cloth lies; none when the scene has no such support.
std::optional<double> SupportRadius(const Scene& scene);

// Scenes of a strip in MakeStrip's place, u = x from 0 to its length [m].

// Held where x ≤ clamp, so that the rest of it bends down along −z under gravity [m/s²]
// (ASTM D1388).
Scene CantileverScene(double clamp, double gravity);
// Held at x = 0, hanging along +x.
Scene HangingStripScene(double gravity);
// Held at x = 0, pulled along +x at x = length by `force` [N]; no gravity.
Scene UniaxialScene(double length, double force);

// A disc held where |x| ≥ radius [m] under gravity along −z. Two rings of held vertices make it
// clamped; one leaves its edge free to turn.
Scene ClampedDiscScene(double radius, double gravity);

}  // namespace drape
