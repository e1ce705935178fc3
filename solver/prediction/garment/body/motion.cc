// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

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

}  // namespace drape
