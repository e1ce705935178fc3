// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/prediction/garment/body/skeleton.h"

namespace drape {

// What the mannequin does [METHODS, P65]: it stands and breathes, walks on one spot at one stride a
// second, turns to and fro, or jumps.
enum class MotionKind { kStand, kWalk, kTurn, kJump };

// "stand", "walk", "turn", "jump".
const std::vector<std::string>& MotionNames();
// Throws InputError, with the names, for another one.
MotionKind ParseMotion(const std::string& name);

// The poses of the mannequin over time. For the first half second its radii grow from half to their
// full size; in the next 0.75 s its arms come down if they were lifted for dressing; then the
// motion sets in smoothly. All angles are sums of sines, so that the motion is periodic.
class MannequinMotion {
 public:
  // arm_angle: between the arms and the body at the beginning [rad], 25° … 90°. Throws InputError
  // (prefix "arms") for others.
  explicit MannequinMotion(MotionKind kind, double arm_angle = kRestArmAngle);

  Pose PoseAt(double t) const;
  double RadiusScale(double t) const;
  double start_of_motion() const { return start_; }  // [s]

 private:
  MotionKind kind_;
  double lift_;  // of the arms at the beginning [rad]
  double start_;
};

}  // namespace drape
