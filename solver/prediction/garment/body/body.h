// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace drape {

// A moving body that wears a garment: a closed surface of triangles that stay the same while their
// vertices move. z is up, the body faces −y, and its left is +x.
class Body {
 public:
  virtual ~Body() = default;

  // Counter-clockwise as seen from outside.
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  int num_vertices() const { return num_vertices_; }

  // Positions of the vertices [m], shape [3B], at time t ≥ 0 [s]. Continuous in t.
  virtual Eigen::VectorXd Positions(double t) const = 0;
  // The rigid motion of the pelvis since t = 0: where a point that moves with it has gone. For
  // waistbands and other rings that the body holds.
  virtual Eigen::Isometry3d PelvisMotion(double t) const = 0;

 protected:
  Body(std::vector<std::array<int, 3>> triangles, int num_vertices)
      : triangles_(std::move(triangles)), num_vertices_(num_vertices) {}

 private:
  std::vector<std::array<int, 3>> triangles_;
  int num_vertices_;
};

struct BodySequenceOptions {
  double frames_per_second = 30;
  double max_speed = 20;  // of a vertex between two frames [m/s]
};

// Reads a user's body: the OBJ files whose names follow from a pattern such as "body_%04d.obj",
// numbered from 0 or 1 to the last that exists, with the same faces in all. Metres, z up. Vertices
// move linearly from frame to frame and rest after the last. The pelvis is the part of the body
// between 45 % and 65 % of its height in the first frame; its motion is the rigid motion that fits
// that of these vertices best.
//
// Throws InputError for a name without one %0Nd, a number out of range (fewer than one frame per
// second, a speed that is not positive), and, naming file and place, for a missing first file, a
// file that ReadObjSurface refuses, a surface that is not closed, whose faces are clockwise as seen
// from outside, or that intersects itself, faces or vertices that differ from those of the first
// frame, and a vertex that moves faster than max_speed.
std::unique_ptr<Body> ReadBodySequence(const std::string& name_pattern,
                                       const BodySequenceOptions& options);

// Makes the body that a user names: "mannequin:walk" (or any other MotionKind), with the arms
// lifted to arm_angle for dressing [rad], or the names of OBJ files, "DIR/body_%04d.obj", which the
// options are for. Throws InputError for another motion, and as Mannequin and ReadBodySequence do.
std::unique_ptr<Body> ParseBody(const std::string& spec, double arm_angle,
                                const BodySequenceOptions& options = {});

}  // namespace drape
