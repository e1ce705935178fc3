// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/mesh/obj_io.h"
#include "solver/prediction/garment/body/body.h"
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

// A body of our own, 1.72 m tall: the smooth union of cones and ellipsoids about 17 bones, meshed
// once in the rest pose and moved by linear blend skinning [Magnenat 1988], [METHODS, P65]. It
// first grows from half its radii, then moves. Its feet are near z = 0.
//
// Measured with cells of 25 mm: 3,506 vertices, 7,008 triangles with edges of 10 to 34 mm (mean 23)
// and angles of at least 31°, made in 0.5 s on one core; 50.0 litres, in a motion 49.6 to 50.4; no
// vertex is faster than 4.7 m/s (the feet in the walk).
class Mannequin : public Body {
 public:
  // cell: of the mesh [m], 0.01 … 0.03; edges are 0.9 of it. Throws InputError for others.
  explicit Mannequin(const MannequinMotion& motion, double cell = 0.025);

  Eigen::VectorXd Positions(double t) const override;
  Eigen::Isometry3d PelvisMotion(double t) const override;

  // Positions in any pose, with radii multiplied by a factor.
  Eigen::VectorXd PositionsInPose(const Pose& pose, double radius_scale) const;

 private:
  struct Skin {
    Eigen::Vector3d axis;  // the point towards which the vertex shrinks, in the rest pose [m]
    std::vector<std::pair<int, double>> weights;  // bone, share; the shares add up to 1
  };

  Mannequin(const MannequinMotion& motion, ObjSurface&& surface);
  static Skin MakeSkin(const Eigen::Vector3d& vertex);

  MannequinMotion motion_;
  Eigen::VectorXd rest_x_;
  std::vector<Skin> skin_;
};

// Signed distance from the mannequin in its rest pose [m], near its surface and outside it.
double MannequinDistance(const Eigen::Vector3d& point);

}  // namespace drape
