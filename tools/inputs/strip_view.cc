// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/strip_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drape {
namespace {

constexpr double kRounding = 1e-9;  // [m]

std::optional<StripView> ViewStrip(const ClothModel& model, const Eigen::VectorXd& x) {
  const auto* held = std::get_if<HalfPlaneRegion>(OnlyHeldRegion(model.scene));
  if (held == nullptr || held->normal.x() < 1.0 - kRounding) return {};
  const Eigen::VectorXd& rest = model.mesh.rest_x;
  double clamp = -std::numeric_limits<double>::infinity(), end = clamp;
  for (const int i : model.held) clamp = std::max(clamp, rest[3 * i]);
  for (int i = 0; i < model.mesh.num_vertices(); ++i) end = std::max(end, rest[3 * i]);
  if (!(end > clamp + kRounding)) return {};
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  int count = 0;
  for (int i = 0; i < model.mesh.num_vertices(); ++i) {
    if (rest[3 * i] < end - kRounding) continue;
    tip += x.segment<3>(3 * i);
    ++count;
  }
  tip /= count;
  StripView view;
  view.length = end - clamp;
  view.drop = -tip.z();
  view.reach = tip.x() - clamp;
  view.chord = std::atan2(view.drop, view.reach) * 180.0 / M_PI;
  view.stretch = std::hypot(view.drop, view.reach) / view.length;
  return view;
}

}  // namespace

UnsupportedView ViewWithoutSupport(const ClothModel& model, const Eigen::VectorXd& x) {
  UnsupportedView view{0.0, 0.0, ViewStrip(model, x)};
  for (int i = 0; i < model.mesh.num_vertices(); ++i) {
    const Eigen::Vector3d move = x.segment<3>(3 * i) - model.mesh.rest_x.segment<3>(3 * i);
    view.largest_move = std::max(view.largest_move, move.norm());
    view.sag = std::max(view.sag, -move.z());
  }
  return view;
}

}  // namespace drape
