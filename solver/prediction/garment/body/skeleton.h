// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <vector>

#include "physics/mesh/obj_io.h"

namespace drape {

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
  Eigen::Vector3d a, b;
  double radius_a, radius_b;                            // [m]
  Eigen::Vector3d half_axes = Eigen::Vector3d::Zero();  // of the ellipsoid [m], else zero
};

struct BoneShape {
  int parent;                  // −1 for the pelvis
  Eigen::Vector3d joint;       // about which it turns in its parent [m]
  Eigen::Vector3d begin, end;  // its axis, towards which its flesh shrinks [m]
  std::vector<Flesh> flesh;
};

const std::array<BoneShape, kNumBones>& Skeleton();

inline constexpr double kRestArmAngle = 0.4363323129985824;  // 25° [rad]

// Angles [rad] of the joints relative to the rest pose. Of pairs the left is first.
struct Pose {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();        // of the pelvis [m]
  double yaw = 0, roll = 0;                               // of the pelvis: about z, about y
  double belly_twist = 0, chest_twist = 0;                // about z
  double chest_bend = 0;                                  // forwards
  double head_turn = 0;                                   // about z
  std::array<double, 2> hip = {}, knee = {}, ankle = {};  // thigh forwards, shin back, toes up
  std::array<double, 2> arm = {}, elbow = {};             // forwards
  std::array<double, 2> arm_lift = {};                    // away from the body
};

// The motion of each bone from the rest pose into a pose.
std::array<Eigen::Isometry3d, kNumBones> BoneMotions(const Pose& pose);

// Signed distance [m] of a point from flesh in the rest pose, negative inside. That of an ellipsoid
// is first-order: only its zero is exact.
double FleshDistance(const Flesh& flesh, const Eigen::Vector3d& point);

// The nearest point of a bone's axis.
Eigen::Vector3d NearestOnAxis(const BoneShape& bone, const Eigen::Vector3d& point);

// Where to look for a surface: x and y from −half to half, z from bottom to top [m].
struct SurfaceNetBox {
  double half_x, half_y, bottom, top;
};

// The zero of a smooth function, positive outside [m], as a closed mesh of triangles that are
// counter-clockwise as seen from outside: one vertex for each sheet of the surface in a cube of
// side `cell` [Gibson 1998], [Nielson 2004], then relaxed along the surface with edges flipped to
// the Delaunay criterion. Mean edge 0.9 cells. The mesh of a function that is even in x is
// symmetric, to rounding. CHECKs that the box contains the surface.
ObjSurface MakeSurfaceNet(const std::function<double(const Eigen::Vector3d&)>& distance,
                          const SurfaceNetBox& box, double cell);

}  // namespace drape
