// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/skeleton.h"

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Flesh Cone(const Vector3d& a, const Vector3d& b, double radius_a, double radius_b) {
  return {a, b, radius_a, radius_b};
}

Flesh Ellipsoid(const Vector3d& centre, const Vector3d& half_axes) {
  return {centre, centre, 0, 0, half_axes};
}

// Moves a point of the left side to the right for side = 1.
Vector3d OnSide(int side, const Vector3d& left) {
  return side == 0 ? left : Vector3d(-left.x(), left.y(), left.z());
}

void AddTrunk(std::array<BoneShape, kNumBones>& bones) {
  bones[kPelvis] = {
      -1, {0, 0, .96}, {0, 0, .90}, {0, 0, 1.00}, {Ellipsoid({0, .012, .94}, {.160, .110, .125})}};
  bones[kBelly] = {kPelvis,
                   {0, 0, 1.04},
                   {0, 0, 1.00},
                   {0, 0, 1.18},
                   {Ellipsoid({0, 0, 1.09}, {.098, .074, .17})}};
  bones[kChest] = {kBelly,
                   {0, .01, 1.18},
                   {0, 0, 1.18},
                   {0, 0, 1.37},
                   {Ellipsoid({0, .005, 1.27}, {.142, .098, .165}),
                    Cone({-.145, .008, 1.378}, {.145, .008, 1.378}, .048, .048)}};
  bones[kNeck] = {kChest,
                  {0, .012, 1.42},
                  {0, .012, 1.42},
                  {0, 0, 1.50},
                  {Cone({0, .012, 1.40}, {0, 0, 1.52}, .052, .048)}};
  bones[kHead] = {kNeck,
                  {0, 0, 1.52},
                  {0, -.012, 1.55},
                  {0, -.012, 1.66},
                  {Ellipsoid({0, -.012, 1.605}, {.076, .093, .115})}};
}

void AddArm(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d down(std::sin(kRestArmAngle), 0, -std::cos(kRestArmAngle));
  const Vector3d shoulder(.168, .008, 1.380);
  const Vector3d elbow = shoulder + .28 * down, wrist = elbow + .25 * down,
                 fingers = wrist + .14 * down;
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kUpperArm + side] = {
      kChest, at(shoulder), at(shoulder), at(elbow), {Cone(at(shoulder), at(elbow), .050, .034)}};
  bones[kForearm + side] = {kUpperArm + side,
                            at(elbow),
                            at(elbow),
                            at(wrist),
                            {Cone(at(elbow), at(wrist), .034, .026),
                             Cone(at(elbow + .04 * down), at(elbow + .10 * down), .033, .030)}};
  bones[kHand + side] = {kForearm + side,
                         at(wrist),
                         at(wrist),
                         at(fingers),
                         {Cone(at(wrist + .05 * down), at(fingers), .036, .028)}};
}

void AddLeg(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d hip(.090, 0, .91), knee(.135, -.01, .50), ankle(.165, .02, .085);
  const Vector3d heel(.165, .035, .040), toes(.185, -.150, .034);
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kThigh + side] = {
      kPelvis, at(hip), at(hip), at(knee), {Cone(at(hip), at(knee), .083, .048)}};
  bones[kShin + side] = {kThigh + side,
                         at(knee),
                         at(knee),
                         at(ankle),
                         {Cone(at(knee), at(ankle), .046, .034),
                          Cone(at({.139, .010, .43}), at({.150, .022, .28}), .042, .036)}};
  bones[kFoot + side] = {
      kShin + side, at(ankle), at(heel), at(toes), {Cone(at(heel), at(toes), .040, .034)}};
}

// The cone with round ends, exact where the ends do not contain one another [m].
double ConeDistance(const Flesh& cone, const Vector3d& point) {
  const Vector3d axis = cone.b - cone.a, p = point - cone.a;
  const double length = axis.norm(), along = p.dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, p.squaredNorm() - along * along));
  const double slope = (cone.radius_a - cone.radius_b) / length;
  const double rise = std::sqrt(1 - slope * slope);
  const double foot = along - across * slope / rise;  // of the normal of the cone, on the axis
  if (foot < 0) return p.norm() - cone.radius_a;
  if (foot > length) return (point - cone.b).norm() - cone.radius_b;
  return across * rise + along * slope - cone.radius_a;
}

double EllipsoidDistance(const Flesh& ellipsoid, const Vector3d& point) {
  const Vector3d scaled = (point - ellipsoid.a).cwiseQuotient(ellipsoid.half_axes);
  const double value = scaled.norm();
  const double slope = scaled.cwiseQuotient(ellipsoid.half_axes).norm();
  if (slope < 1e-9) return -ellipsoid.half_axes.minCoeff();
  return value * (value - 1) / slope;
}

AngleAxisd About(const Vector3d& axis, double angle) { return {angle, axis}; }

// The rotation of each bone in its parent.
std::array<Eigen::Quaterniond, kNumBones> JointRotations(const Pose& pose) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  std::array<Eigen::Quaterniond, kNumBones> turn;
  turn.fill(Eigen::Quaterniond::Identity());
  turn[kPelvis] = (About(z, pose.yaw) * About(y, pose.roll));
  turn[kBelly] = About(z, pose.belly_twist);
  turn[kChest] = (About(z, pose.chest_twist) * About(x, pose.chest_bend));
  turn[kHead] = About(z, pose.head_turn);
  for (int side = 0; side < 2; ++side) {
    const double away = side == 0 ? -1 : 1;  // about y, from the body
    turn[kThigh + side] = About(x, -pose.hip[side]);
    turn[kShin + side] = About(x, pose.knee[side]);
    turn[kFoot + side] = About(x, -pose.ankle[side]);
    turn[kUpperArm + side] = (About(x, -pose.arm[side]) * About(y, away * pose.arm_lift[side]));
    turn[kForearm + side] = About(x, -pose.elbow[side]);
  }
  return turn;
}

}  // namespace

const std::array<BoneShape, kNumBones>& Skeleton() {
  static const std::array<BoneShape, kNumBones> bones = [] {
    std::array<BoneShape, kNumBones> made;
    AddTrunk(made);
    for (int side = 0; side < 2; ++side) {
      AddArm(side, made);
      AddLeg(side, made);
    }
    return made;
  }();
  return bones;
}

std::array<Eigen::Isometry3d, kNumBones> BoneMotions(const Pose& pose) {
  const auto& bones = Skeleton();
  const auto turn = JointRotations(pose);
  std::array<Eigen::Isometry3d, kNumBones> motion;
  for (int b = 0; b < kNumBones; ++b) {  // parents come first
    const int parent = bones[b].parent;
    motion[b] = parent < 0 ? Eigen::Isometry3d(Eigen::Translation3d(pose.shift)) : motion[parent];
    motion[b] = motion[b] * Eigen::Translation3d(bones[b].joint) * turn[b] *
                Eigen::Translation3d(-bones[b].joint);
  }
  return motion;
}

double FleshDistance(const Flesh& flesh, const Vector3d& point) {
  return flesh.half_axes.isZero() ? ConeDistance(flesh, point) : EllipsoidDistance(flesh, point);
}

Vector3d NearestOnAxis(const BoneShape& bone, const Vector3d& point) {
  const Vector3d axis = bone.end - bone.begin;
  const double share = (point - bone.begin).dot(axis) / axis.squaredNorm();
  return bone.begin + std::clamp(share, 0.0, 1.0) * axis;
}

}  // namespace drape
