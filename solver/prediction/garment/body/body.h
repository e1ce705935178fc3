// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "physics/util/options/field.h"
#include "solver/prediction/garment/body/limbs.h"
#include "solver/prediction/garment/body/stance.h"

namespace drape {

inline constexpr double kGrowSeconds = .5;    // in which a body grows to its size [s]
inline constexpr double kLowerSeconds = .75;  // in which limbs go back to their place then [s]

// A moving body that wears a garment: a closed surface of triangles that stay the same while their
// vertices move. z is up, the body faces −y, and its left is +x.
class Body {
 public:
  virtual ~Body() = default;

  // Counter-clockwise as seen from outside.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  int num_vertices() const { return num_vertices_; }
  // The number of files of a user's body, how they were meant, and the time of the last one [s];
  // of the mannequin 0.
  int num_files() const { return num_files_; }
  const BodyFiles& files() const { return files_; }
  double rests_after() const {
    return num_files_ == 0 ? 0 : start_ + (num_files_ - 1) / files_.frames_per_second;
  }
  // While it grows from limbs drawn together, a garment that nothing holds yet has no weight [s].
  double weightless_until() const { return weightless_until_; }

  // Positions of the vertices [m], shape [3B], at time t ≥ 0 [s]. Continuous in t.
  virtual Eigen::VectorXd Positions(double t) const = 0;
  // The rigid motion of the pelvis since t = 0: where a point that moves with it has gone. For
  // waistbands and other rings that the body holds.
  virtual Eigen::Isometry3d PelvisMotion(double t) const = 0;
  // Lets arms and legs begin in the tubes of a garment, with a note, if it grows as files do.
  void ReachInto(const std::vector<ClothTube>& tubes);

 protected:
  Body(std::vector<std::array<int, 3>> triangles, int num_vertices)
      : triangles_(std::move(triangles)), num_vertices_(num_vertices) {}

  // Lets a person begin with its limbs drawn together, and the arms at this angle off the body
  // [rad]; 0: where they are.
  void BeginThin(const Eigen::VectorXd& person, double arm_angle);
  // The way of its vertices from there to x, which they have reached at start_.
  Eigen::VectorXd Growing(double t, Eigen::VectorXd x) const;

  double start_ = 0.0;  // of the motion [s]
  int num_files_ = 0;
  BodyFiles files_ = {};
  double weightless_until_ = 0.0;

 private:
  void MoveLimbs(bool any);

  std::vector<std::array<int, 3>> triangles_;
  int num_vertices_;
  Eigen::VectorXd person_;  // as it is grown [m]; empty: it does not begin thin
  Eigen::VectorXd shrunk_;  // how far its vertices are off at t = 0 [m]
  Limbs limbs_;
};

// Reads a user's body: one file (ReadSurface), or those whose names follow from a pattern such as
// "body_%04d.obj", numbered from 0 or 1 to the last without a gap, with the same faces in all; as
// FindStance finds that they are meant. A surface that is inside out is turned over. One that is
// open is wrapped with a note, and the wrap moves along (Wrap, Follower). A body that meets itself
// is noted, and parts of it without room for cloth between them are pressed in with a note
// (PressIn). For the first half second the body grows to its size (Limbs), unless files.grow is
// false; where arm_angle > 0, its arms are turned to that angle off the body [rad], and go back to
// their place in the next 0.75 s. Then vertices move linearly from frame to frame, and rest after
// the last. The pelvis is the part of the body between 45 % and 65 % of its height in the first
// frame; its motion is the rigid motion that fits that of these vertices best.
//
// Throws InputError for a name with more than one number, for fewer than one frame per second, and,
// naming file and place, for a missing file, a file that ReadSurface or FindStance refuses, faces
// or vertices that differ from those of the first frame, and a vertex faster than 20 m/s.
std::unique_ptr<Body> ReadBodySequence(const std::string& name_pattern, const BodyFiles& files,
                                       double arm_angle = 0);

// Makes the body that a user names: "mannequin:walk" (or any other MotionKind), or the names of
// files, "DIR/body_%04d.obj", with the arms turned to arm_angle for dressing [rad]; 0: not stated.
// Throws InputError for another motion, and as Mannequin and ReadBodySequence do.
std::unique_ptr<Body> ParseBody(const std::string& spec, double arm_angle,
                                const BodyFiles& files = {});

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
  // arm_angle: between the arms and the body at the beginning [rad], 25° … 90°; 0: not stated, 80°,
  // and it grows as ReadBodySequence lets bodies grow, for garments that were not placed around
  // half of its radii. Throws InputError (prefix "arms") for others.
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
  double lift_;  // of the arms at the beginning [rad]
  Eigen::VectorXd rest_x_;
  std::vector<Skin> skin_;
};

}  // namespace drape
