// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "physics/util/options/enum_names.h"
#include "solver/prediction/garment/body/body.h"

namespace drape {

// What the mannequin does [METHODS, P65]: it stands and breathes, walks on one spot at one stride a
// second, turns to and fro, or jumps.
enum class MotionKind { kStand, kWalk, kTurn, kJump };
constexpr auto EnumNames(MotionKind) {
  return MakeNames<MotionKind>({{MotionKind::kStand, "stand"},
                                {MotionKind::kWalk, "walk"},
                                {MotionKind::kTurn, "turn"},
                                {MotionKind::kJump, "jump"}});
}

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

// A body of our own, 1.72 m tall: a mesh of 3,506 vertices in the rest pose (mannequin.obj), moved
// by linear blend skinning [Magnenat 1988] about 17 bones [METHODS, P65]. Its feet are near z = 0.
// For the first half second its radii grow from half to their full size. In the next 0.75 s its
// arms come down if they were lifted for dressing. Then the motion sets in smoothly. All angles are
// sums of sines, so that the motion is periodic.
//
// Measured: edges of 10 to 34 mm (mean 23) and angles of at least 31°; 50.0 litres, in a motion
// 49.6 to 50.4; no vertex is faster than 4.7 m/s (the feet in the walk).
class Mannequin : public Body {
 public:
  // arm_angle: between the arms and the body at the beginning [rad], 25° … 90°. Throws InputError
  // (prefix "arms") for others.
  explicit Mannequin(MotionKind kind, double arm_angle = kRestArmAngle);

  Eigen::VectorXd Positions(double t) const override;
  Eigen::Isometry3d PelvisMotion(double t) const override;

  // Positions in any pose, with radii multiplied by a factor.
  Eigen::VectorXd PositionsInPose(const Pose& pose, double radius_scale) const;

 private:
  struct Skin {
    Eigen::Vector3d axis;  // the point towards which the vertex shrinks, in the rest pose [m]
    std::vector<std::pair<int, double>> weights;  // bone, share; the shares add up to 1
  };
  static Skin MakeSkin(const Eigen::Vector3d& vertex);
  Pose PoseAt(double t) const;

  MotionKind kind_;
  double lift_;   // of the arms at the beginning [rad]
  double start_;  // of the motion [s]
  Eigen::VectorXd rest_x_;
  std::vector<Skin> skin_;
};

}  // namespace drape
