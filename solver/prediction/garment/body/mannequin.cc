// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/mannequin.h"

#include <cmath>
#include <limits>
#include <string>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/surface_net.h"

namespace drape {
namespace {

using Eigen::Vector3d;

constexpr double kBlend = .012;      // of the smooth union [m]
constexpr double kSkinWidth = .030;  // over which the weights of the bones blend [m]
constexpr double kLeastWeight = 1e-4;
constexpr SurfaceNetBox kBox = {.56, .26, -.04, 1.78};

double NearestFlesh(const BoneShape& bone, const Vector3d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Flesh& flesh : bone.flesh) nearest = std::min(nearest, FleshDistance(flesh, point));
  return nearest;
}

double CheckedCell(double cell) {
  if (!(cell >= .01 && cell <= .03))
    throw InputError("mannequin", Format("cells of %g m, expected 0.01 … 0.03 m", cell));
  return cell;
}

}  // namespace

double MannequinDistance(const Vector3d& point) {
  constexpr double kFarthest = 25;  // in units of the blend: of no effect in double precision
  std::array<double, 2 * kNumBones> distance{};
  size_t count = 0;
  for (const BoneShape& bone : Skeleton())
    for (const Flesh& flesh : bone.flesh) distance.at(count++) = FleshDistance(flesh, point);
  const double least = *std::min_element(distance.begin(), distance.begin() + count);
  double sum = 0;
  for (size_t k = 0; k < count; ++k) {
    const double apart = (distance[k] - least) / kBlend;
    if (apart < kFarthest) sum += std::exp(-apart);
  }
  return least - kBlend * std::log(sum);
}

Mannequin::Mannequin(const MannequinMotion& motion, double cell)
    : Mannequin(motion, MakeSurfaceNet(MannequinDistance, kBox, CheckedCell(cell))) {}

Mannequin::Mannequin(const MannequinMotion& motion, ObjSurface&& surface)
    : Body(std::move(surface.triangles), static_cast<int>(surface.x.size() / 3)),
      motion_(motion),
      rest_x_(std::move(surface.x)) {
  for (int i = 0; i < num_vertices(); ++i) skin_.push_back(MakeSkin(rest_x_.segment<3>(3 * i)));
}

Mannequin::Skin Mannequin::MakeSkin(const Vector3d& vertex) {
  std::array<double, kNumBones> distance;
  for (int b = 0; b < kNumBones; ++b) distance[b] = NearestFlesh(Skeleton()[b], vertex);
  const double least = *std::min_element(distance.begin(), distance.end());
  Skin skin{Vector3d::Zero(), {}};
  double sum = 0;
  for (int b = 0; b < kNumBones; ++b) {
    const double apart = (distance[b] - least) / kSkinWidth;
    const double weight = std::exp(-apart * apart);
    if (weight < kLeastWeight) continue;
    skin.weights.emplace_back(b, weight);
    sum += weight;
  }
  for (auto& [bone, weight] : skin.weights) {
    weight /= sum;
    skin.axis += weight * NearestOnAxis(Skeleton()[bone], vertex);
  }
  return skin;
}

Eigen::VectorXd Mannequin::PositionsInPose(const Pose& pose, double radius_scale) const {
  const auto motions = BoneMotions(pose);
  Eigen::VectorXd x(rest_x_.size());
  for (int i = 0; i < num_vertices(); ++i) {
    const Skin& skin = skin_[i];
    const Vector3d rest = skin.axis + radius_scale * (rest_x_.segment<3>(3 * i) - skin.axis);
    Vector3d moved = Vector3d::Zero();
    for (const auto& [bone, weight] : skin.weights) moved += weight * (motions[bone] * rest);
    x.segment<3>(3 * i) = moved;
  }
  return x;
}

Eigen::VectorXd Mannequin::Positions(double t) const {
  return PositionsInPose(motion_.PoseAt(t), motion_.RadiusScale(t));
}

Eigen::Isometry3d Mannequin::PelvisMotion(double t) const {
  return BoneMotions(motion_.PoseAt(t))[kPelvis] *
         BoneMotions(motion_.PoseAt(0))[kPelvis].inverse();
}

}  // namespace drape
