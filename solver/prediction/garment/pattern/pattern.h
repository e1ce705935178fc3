// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace drape {

// The sewing pattern of a garment: flat panels, the seams between them, and where the panels are
// before they are sewn. Weft is x and warp is y of a panel's plane; its outer side faces those who
// see its outline run counter-clockwise.

// An edge of an outline, from one corner to the next: straight, a Bézier curve of degree two or
// three, or an arc of a circle.
struct PatternEdge {
  Eigen::Vector2d begin, end;                 // [m]
  std::vector<Eigen::Vector2d> control = {};  // of a Bézier curve: one or two points [m]
  // The signed angle of an arc [rad], positive counter-clockwise; zero for the other kinds.
  double arc_angle = 0;

  // The point at share s = 0 … 1 of the curve's own parameter [m].
  Eigen::Vector2d At(double s) const;
  // The length by chords of 1/512 of the parameter [m].
  double Length() const;
  // n + 1 points at equal distances along the curve, both ends included, which are exact. n ≥ 1.
  std::vector<Eigen::Vector2d> Divided(int n) const;
};

// The arc through begin and end of this radius [m], the signed angle as in PatternEdge: the shorter
// of the two or the longer one. A radius of less than half the distance counts as half, as in SVG.
PatternEdge MakeArc(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double radius,
                    bool large, bool counter_clockwise);

// A closed loop: each edge begins where the one before it ends.
using PatternLoop = std::vector<PatternEdge>;

struct Panel {
  std::string name;
  PatternLoop outline;             // counter-clockwise
  std::vector<PatternLoop> holes;  // clockwise
  // From the panel's plane into the world; z of the plane is the outer side.
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  // The panel is bent about the line x = 0 to a cylinder of this radius [m] that has the line on it
  // and the outer side outside; 0 = flat.
  double cylinder_radius = 0;

  // The edges of the outline, then those of the holes, which is how stitches and rings count them.
  int num_edges() const;
  const PatternEdge& edge(int index) const;
  // Where a point of the plane is before sewing [m].
  Eigen::Vector3d Place(const Eigen::Vector2d& point) const;
};

struct PanelEdge {
  int panel = 0, edge = 0;
};

// A seam: the edges are joined end to begin and begin to end, as those of neighbouring faces are,
// or begin to begin.
struct Stitch {
  PanelEdge first, second;
  bool same_direction = false;
  bool ease = false;  // the longer edge is gathered
};

// Edges of one panel that are held, such as a waistband by the pelvis.
struct Ring {
  std::string name;
  int panel = 0;
  std::vector<int> edges;
  bool held_by_pelvis = false;
};

struct Pattern {
  std::string name;
  std::vector<Panel> panels;
  std::vector<Stitch> stitches;
  std::vector<Ring> rings;
  double arm_angle = 0;  // between the arms and the body for dressing [rad]; 0: not stated
};

// What is wrong with a pattern, with the place in it, such as "panels.front": two edges that cross
// or touch, a hole outside the outline, a seam whose edges differ by more than 5 % of the longer
// one without ease, an edge in more than one seam, a panel so wide that its cylinder overlaps
// itself. An empty problem stands for none. Loops must be closed.
struct PatternProblem {
  std::string key, found, expected;
};
PatternProblem FindProblem(const Pattern& pattern);

// Signed area of a loop [m²], positive counter-clockwise.
double LoopArea(const PatternLoop& loop);

// Reads a pattern of our own format ("drapefit-garment", configs/README.md) or a specification of
// GarmentCode [Korosteleva 2023], which has a key "pattern". Of that: straight, quadratic, cubic
// and circular edges, curvature as two numbers of older files, seams of the third entry
// "right_wrong", lengths by "units_in_meter", y up and facing +z, which are turned to z up and
// facing −y. Labels and parameters are skipped. A panel whose outline is clockwise is turned over,
// so that edges keep their numbers.
//
// Throws InputError "file: key 'panels.front.outline[2]': found …, expected …" for a missing or
// unknown key (of our own format), a number out of range, an outline that is not closed, a seam of
// a panel or edge that there is not, and whatever FindProblem finds.
Pattern ReadPattern(const std::string& path);

}  // namespace drape
