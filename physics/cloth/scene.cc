// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/scene.h"

namespace drape {
namespace {

// A ring or row of vertices exactly on a bound counts as inside, whichever way it is rounded.
constexpr double kRounding = 1e-12;
// So stiff that a clamp yields by less than 1e-8 of the deflection of its load.
constexpr double kClampStiffness = 1e6;  // [N/m]

bool IsInside(const DiscRegion& disc, const Eigen::Vector3d& x) {
  return (x - disc.centre).norm() < disc.radius * (1.0 + kRounding);
}
bool IsInside(const RingRegion& ring, const Eigen::Vector3d& x) {
  const double radius = (x - ring.centre).norm();
  return radius > ring.inner * (1.0 - kRounding) && radius < ring.outer * (1.0 + kRounding);
}
bool IsInside(const HalfPlaneRegion& plane, const Eigen::Vector3d& x) {
  return plane.normal.dot(x) <= plane.offset + kRounding;
}

Scene Clamped(const Region& region, const Eigen::Vector3d& gravity) {
  Scene scene;
  scene.gravity = gravity;
  scene.handles = Handles{.regions = {region}, .stiffness = kClampStiffness};
  return scene;
}

}  // namespace

bool Contains(const Region& region, const Eigen::Vector3d& rest_x) {
  return std::visit([&](const auto& shape) { return IsInside(shape, rest_x); }, region);
}

Scene CusickScene(const CusickContact& contact, double support_radius) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.handles = Handles{.regions = {DiscRegion{.radius = support_radius}}};
  if (contact.model != ContactModel::kNone) {
    Contact& with = scene.contact.emplace();
    with.thickness = contact.thickness;
    with.self = contact.model == ContactModel::kSelf;
    // So far below z = 0 that it does not push what is held there.
    const double depth = with.offset() + 1.1 * with.range;
    with.obstacles = {PlateObstacle{.top = {0.0, 0.0, -depth}, .radius = support_radius}};
  }
  return scene;
}

const Region* OnlyHeldRegion(const Scene& scene) {
  const auto& handles = scene.handles;
  const bool is_one = handles && handles->regions.size() == 1 && handles->vertices.empty();
  return is_one ? &handles->regions.front() : nullptr;
}

std::optional<double> SupportRadius(const Scene& scene) {
  const auto* support = std::get_if<DiscRegion>(OnlyHeldRegion(scene));
  if (support == nullptr || !support->centre.isZero(0.0)) return std::nullopt;
  return support->radius;
}

Scene CantileverScene(double clamp, double gravity) {
  return Clamped(HalfPlaneRegion{.offset = clamp}, {0.0, 0.0, -gravity});
}

Scene HangingStripScene(double gravity) {
  return Clamped(HalfPlaneRegion{.offset = 0.0}, {gravity, 0.0, 0.0});
}

Scene UniaxialScene(double length, double force) {
  Scene scene = HangingStripScene(0.0);
  scene.gravity.reset();
  scene.load =
      EdgeLoad{.region = HalfPlaneRegion{.normal = -Eigen::Vector3d::UnitX(), .offset = -length},
               .force = {force, 0.0, 0.0}};
  return scene;
}

}  // namespace drape
