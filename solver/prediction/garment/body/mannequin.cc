// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/mannequin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/skeleton.h"

namespace drape {
namespace {

constexpr double kGrowSeconds = .5, kLowerSeconds = .75, kRampSeconds = .5;
constexpr double kLeastRadiusScale = .5;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn = 2 * std::numbers::pi;

// From 0 at s ≤ 0 to 1 at s ≥ 1, with two continuous derivatives.
double SmoothStep(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (s * (6 * s - 15) + 10);
}

// Each motion at the time t since it set in, with its amplitude a.
Pose Stand(double t, double a) {
  Pose pose;
  pose.shift.x() = a * .008 * std::sin(kTurn * .25 * t);
  pose.chest_bend = a * 1.5 * kDegree * std::sin(kTurn * .25 * t);
  pose.head_turn = a * 10 * kDegree * std::sin(kTurn * .1 * t);
  return pose;
}

Pose Walk(double t, double a) {
  const double phase = kTurn * t;  // one stride, two steps, a second
  Pose pose;
  pose.shift = a * Eigen::Vector3d(.02 * std::sin(phase), 0, .02 * std::cos(2 * phase));
  pose.yaw = -a * 4 * kDegree * std::sin(phase);
  pose.roll = a * 3 * kDegree * std::sin(phase);
  pose.belly_twist = a * 4 * kDegree * std::sin(phase);
  pose.chest_twist = a * 5 * kDegree * std::sin(phase);
  for (int side = 0; side < 2; ++side) {
    const double leg = phase + side * std::numbers::pi;
    pose.hip[side] = a * 25 * kDegree * std::sin(leg);
    const double swing = leg + .2;  // the knee is bent most as the thigh passes the vertical
    pose.knee[side] = a * (21 + 26 * std::cos(swing) + 13 * std::cos(2 * swing)) * kDegree;
    pose.ankle[side] = a * 10 * kDegree * std::sin(leg);
    pose.arm[side] = -a * 20 * kDegree * std::sin(leg);
    pose.elbow[side] = a * (20 - 10 * std::sin(leg)) * kDegree;
  }
  return pose;
}

Pose Turn(double t, double a) {
  const double phase = kTurn * .5 * t;
  Pose pose;
  pose.yaw = a * 90 * kDegree * std::sin(phase);
  pose.belly_twist = a * 8 * kDegree * std::cos(phase);
  pose.chest_twist = a * 10 * kDegree * std::cos(phase);
  pose.head_turn = a * 15 * kDegree * std::cos(phase);
  for (int side = 0; side < 2; ++side) pose.arm_lift[side] = a * 12 * kDegree;
  return pose;
}

Pose Jump(double t, double a) {
  const double phase = kTurn * 1.25 * t;
  const double crouch = a * .5 * (1 + std::cos(phase));
  Pose pose;
  pose.shift.z() = a * (.03 - .09 * std::cos(phase));
  pose.chest_bend = 6 * kDegree * crouch;
  for (int side = 0; side < 2; ++side) {
    pose.hip[side] = 22 * kDegree * crouch;
    pose.knee[side] = 45 * kDegree * crouch;
    pose.ankle[side] = 23 * kDegree * crouch;
    pose.arm[side] = -15 * kDegree * crouch;
    pose.arm_lift[side] = a * 15 * kDegree * (1 - std::cos(phase)) * .5;
    pose.elbow[side] = 20 * kDegree * crouch;
  }
  return pose;
}

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

const std::vector<std::string>& MotionNames() {
  static const std::vector<std::string> names = {"stand", "walk", "turn", "jump"};
  return names;
}

MotionKind ParseMotion(const std::string& name) {
  const auto& names = MotionNames();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw InputError("motion",
                     "found '" + MakePrintableLine(name) + "', expected stand, walk, turn or jump");
  return static_cast<MotionKind>(found - names.begin());
}

MannequinMotion::MannequinMotion(MotionKind kind, double arm_angle)
    : kind_(kind), lift_(arm_angle - kRestArmAngle) {
  if (!(lift_ >= -1e-9 && arm_angle <= std::numbers::pi / 2 + 1e-9))
    throw InputError("arms", Format("%g° off the body, expected 25° … 90°", arm_angle / kDegree));
  start_ = kGrowSeconds + (lift_ > 1e-9 ? kLowerSeconds : 0);
}

Pose MannequinMotion::PoseAt(double t) const {
  constexpr Pose (*kPoses[])(double, double) = {Stand, Walk, Turn, Jump};
  Pose pose = kPoses[static_cast<int>(kind_)](t - start_, SmoothStep((t - start_) / kRampSeconds));
  const double lowered = SmoothStep((t - kGrowSeconds) / kLowerSeconds);
  for (double& lift : pose.arm_lift) lift += (1 - lowered) * lift_;
  return pose;
}

double MannequinMotion::RadiusScale(double t) const {
  return kLeastRadiusScale + (1 - kLeastRadiusScale) * SmoothStep(t / kGrowSeconds);
}

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
