// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/body/wrap.h"

namespace drape {

// The file mannequin.obj as it was when the library was built.
extern const char* const kMannequinObj;

namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;
// The bones of the mannequin, 1.72 m tall, in its rest pose: arms 25° off the body, legs apart.
// Right is −x and mirrors left.
enum Bone {
  kPelvis,
  kBelly,
  kChest,
  kNeck,
  kHead,
  kUpperArm,  // left, then right, and so on
  kForearm = kUpperArm + 2,
  kHand = kForearm + 2,
  kThigh = kHand + 2,
  kShin = kThigh + 2,
  kFoot = kShin + 2,
  kNumBones = kFoot + 2
};

// One of the shapes of which a bone's flesh is the union: a cone with round ends between two points
// [m], or an ellipsoid about the first of them.
struct Flesh {
  Vector3d a, b;
  double radius_a, radius_b;              // [m]
  Vector3d half_axes = Vector3d::Zero();  // of the ellipsoid [m], else zero
};

struct BoneShape {
  int parent;           // −1 for the pelvis
  Vector3d joint;       // about which it turns in its parent [m]
  Vector3d begin, end;  // its axis, towards which its flesh shrinks [m]
  std::vector<Flesh> flesh;
};

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

// The motion of each bone from the rest pose into a pose.
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

// Signed distance [m] of a point from flesh in the rest pose, negative inside. The distance from an
// ellipsoid is first-order: only its zero is exact.
double FleshDistance(const Flesh& flesh, const Vector3d& point) {
  return flesh.half_axes.isZero() ? ConeDistance(flesh, point) : EllipsoidDistance(flesh, point);
}

// The nearest point of a bone's axis.
Vector3d NearestOnAxis(const BoneShape& bone, const Vector3d& point) {
  const Vector3d axis = bone.end - bone.begin;
  const double share = (point - bone.begin).dot(axis) / axis.squaredNorm();
  return bone.begin + std::clamp(share, 0.0, 1.0) * axis;
}

constexpr double kRampSeconds = .5;
constexpr double kLeastRadiusScale = .5;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurn = 2 * std::numbers::pi;

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
  pose.shift = a * Vector3d(.02 * std::sin(phase), 0, .02 * std::cos(2 * phase));
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

constexpr double kSkinWidth = .030;  // over which the weights of the bones blend [m]
constexpr double kLeastWeight = 1e-4;

double NearestFlesh(const BoneShape& bone, const Vector3d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Flesh& flesh : bone.flesh) nearest = std::min(nearest, FleshDistance(flesh, point));
  return nearest;
}

const ObjContent& RestMesh() {
  static const ObjContent mesh = ParseObj(kMannequinObj, "mannequin.obj", false);
  return mesh;
}

std::vector<std::array<int, 3>> RestTriangles() {
  std::vector<std::array<int, 3>> triangles;
  for (const ObjFace& face : RestMesh().faces)
    triangles.push_back({face.corner[0].v, face.corner[1].v, face.corner[2].v});
  return triangles;
}

}  // namespace

// The angle of the arms out of the way of a garment without sleeves [rad].
constexpr double kClear = 80 * kDegree;

Mannequin::Mannequin(MotionKind kind, double arm_angle)
    : Body(RestTriangles(), static_cast<int>(RestMesh().v.size())),
      kind_(kind),
      lift_(arm_angle == 0 ? 0 : arm_angle - kRestArmAngle) {
  if (!(lift_ >= -1e-9 && arm_angle <= std::numbers::pi / 2 + 1e-9))
    throw InputError("arms", Format("%g° off the body, expected 25° … 90°", arm_angle / kDegree));
  start_ = kGrowSeconds + (lift_ > 1e-9 ? kLowerSeconds : 0);
  rest_x_.resize(3 * num_vertices());
  for (int i = 0; i < num_vertices(); ++i) {
    rest_x_.segment<3>(3 * i) = RestMesh().v[i];
    skin_.push_back(MakeSkin(RestMesh().v[i]));
  }
  if (arm_angle == 0) BeginThin(PositionsInPose(PoseAt(0), 1), kClear);
}

Pose Mannequin::PoseAt(double t) const {
  constexpr Pose (*kPoses[])(double, double) = {Stand, Walk, Turn, Jump};
  Pose pose = kPoses[static_cast<int>(kind_)](t - start_, SmoothStep((t - start_) / kRampSeconds));
  const double lowered = SmoothStep((t - kGrowSeconds) / kLowerSeconds);
  for (double& lift : pose.arm_lift) lift += (1 - lowered) * lift_;
  return pose;
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
  const double grown = SmoothStep(t / kGrowSeconds);
  if (weightless_until() > 0) return Growing(t, PositionsInPose(PoseAt(t), 1));
  return PositionsInPose(PoseAt(t), kLeastRadiusScale + (1 - kLeastRadiusScale) * grown);
}

Eigen::Isometry3d Mannequin::PelvisMotion(double t) const {
  return BoneMotions(PoseAt(t))[kPelvis] * BoneMotions(PoseAt(0))[kPelvis].inverse();
}

}  // namespace drape
