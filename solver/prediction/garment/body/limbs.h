// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "physics/mesh/obj_io.h"

namespace drape {

// A sleeve or a leg of trousers: rings of cloth from its cuff to the body.
struct ClothRing {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // [m]
  double inner = HUGE_VAL;                           // how near it comes to the plane x = 0 [m]
};
using ClothTube = std::vector<ClothRing>;

// The arms and legs of a standing person, z up, facing −y, which move for dressing.
class Limbs {
 public:
  Limbs() = default;
  explicit Limbs(const ObjSurface& person);

  // The person as it begins to grow, not moved: drawn together to its axes, limbs to a quarter of
  // their radii or less, but legs not up or down, as the crotch would come down between them [m],
  // shape [3V].
  const Eigen::VectorXd& thin() const { return thin_; }
  // Turns the arms to an angle off the body [rad].
  void TurnArms(double angle);
  // Moves one limb until the line of its middles runs through those of a tube: that which reaches
  // up to the shoulders is for an arm. Returns what has moved: "left leg turned by 7 degrees and
  // moved by 2.1 cm"; empty where there is no such limb.
  std::string ReachInto(const ClothTube& tube);
  // Moves the limbs of x, shape [3V], by a share of their way.
  void Move(double share, Eigen::VectorXd& x) const;

 private:
  struct Limb {
    Eigen::Vector3d joint = Eigen::Vector3d::Zero();  // [m]
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    double length = 0;  // [m]; 0: the person has none
    Eigen::AngleAxisd turn = Eigen::AngleAxisd::Identity();
    // The shift at a distance s from the joint is bend·(s, s², s³), and beyond `to` as there [m].
    Eigen::Matrix3d bend = Eigen::Matrix3d::Zero();
    double to = 0;
  };
  void DrawIn(const Limb& limb);
  Eigen::Vector3d Middle(const Limb& limb, double far) const;

  double low_ = 0, height_ = 1;  // [m]
  Eigen::VectorXd thin_;
  Eigen::VectorXd share_;           // of the motion of its limb, for each vertex
  std::vector<int> limb_of_;        // each vertex
  std::array<Limb, 4> limbs_ = {};  // arms, then legs; the left one is first
};

}  // namespace drape
