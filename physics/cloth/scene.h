// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/mesh/disc.h"

namespace drape {

// Regions select vertices by their rest position; bounds are included to rounding [m] [MODEL, M28].
struct DiscRegion {
  double radius = DrapeDiscs().support;  // |x_rest − centre| ≤ radius
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};
struct RingRegion {
  double inner = 0.0;  // inner ≤ |x_rest − centre| ≤ outer
  double outer = std::numeric_limits<double>::infinity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};
struct HalfPlaneRegion {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // unit length
  double offset = 0.0;                                // normal·x_rest ≤ offset
};
using Region = std::variant<DiscRegion, RingRegion, HalfPlaneRegion>;
bool Contains(const Region& region, const Eigen::Vector3d& rest_x);

// The forces that act [MODEL, M28]. A term that is not listed takes neither memory nor time.
struct Handles {
  // Held are the vertices in any of the regions, and those of these numbers (from 0, in the order
  // of the mesh).
  std::vector<Region> regions = {DiscRegion()};
  std::vector<int> vertices = {};
  double stiffness = 1e3;  // spring of each held vertex to its rest position [N/m]
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
  std::optional<Contact> contact;
};

// What the hanging part of a cloth in the drape test can touch (names: scene_io.h).
enum class ContactModel {
  kNone,     // nothing: it hangs through the support and through itself
  kSupport,  // the support, a plate just below the cloth that is held
  kSelf      // the support and itself
};
struct CusickContact {
  ContactModel model = ContactModel::kNone;
  double thickness = Contact().thickness;  // of the cloth [m]
};

// The drape test [BS 5058], [ISO 9073-9], [MODEL, M29]: a support of that radius [m] and gravity
// −9.8 m/s² along z.
Scene CusickScene(const CusickContact& contact = {}, double support_radius = DrapeDiscs().support);
// The radius of the disc on which the cloth lies [m]; std::nullopt when the scene has no such
// support: one disc about the origin that is all that is held.
std::optional<double> SupportRadius(const Scene& scene);

// The only region that is held, where nothing else is; nullptr otherwise.
const Region* OnlyHeldRegion(const Scene& scene);

// Scenes of a strip as MakeStrip places it, u = x from 0 to its length [m].

// The cantilever test [ASTM D1388]: the strip is held where x ≤ clamp [m], and the rest of it bends
// down along −z under gravity [m/s²].
Scene CantileverScene(double clamp, double gravity);
// The strip is held at x = 0 and hangs along +x under gravity [m/s²].
Scene HangingStripScene(double gravity);
// The strip is held at x = 0 and pulled along +x at x = length [m] by `force` [N], without gravity.
Scene UniaxialScene(double length, double force);

}  // namespace drape
