// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/options/field.h"

namespace drape {

// What a textile laboratory measures on a strip, as data of a fit.

enum class LabMeasurementKind {
  kCantilever,  // overhang length [m] → chord angle below the horizontal [°] [ASTM D1388]
  kTensile      // force [N] → stretch, length by rest length (strip method)
};
constexpr auto EnumNames(LabMeasurementKind) {
  return MakeNames<LabMeasurementKind>(
      {{LabMeasurementKind::kCantilever, "cantilever"}, {LabMeasurementKind::kTensile, "tensile"}});
}

// What was set and what was read: overhang and angle, or force and stretch.
struct LabPoint {
  double set = 0.0;
  double reading = 0.0;
};

// One strip, cut at `direction` to the weft.
struct LabMeasurement {
  std::string name = {};  // file name without folder and extension
  std::string file = {};
  LabMeasurementKind kind = LabMeasurementKind::kCantilever;
  double direction = 0.0;             // [°]: 0 weft, 90 warp, 45 bias
  double length = 0.0;                // at rest between the grips [m]; tensile only
  double width = 0.0;                 // [m]; tensile only: of a cantilever it cancels
  double sigma = 1.0;                 // standard deviation of a reading [°] or [1]
  std::vector<LabPoint> points = {};  // by rising overhang or force
  double density = 0.0;               // of the fabric, as the file states [kg/m²]; 0: it does not
};

// The measurements of one file that a user names, in one of two forms. Throws InputError (file,
// key, value, what was expected) for a key that is unknown or missing, a value out of range or in
// another unit (CheckUsual), and strips without a loading or without a stretch.
//
// One measurement, whose points may be in any order; `width` of a cantilever may be left out:
//   {"test": "cantilever", "direction": 0, "sigma": 1.0, "width": 0.025,
//    "points": [{"length": 0.06, "angle": 41.5}, …]}
//   {"test": "tensile", "direction": 90, "length": 0.2, "width": 0.05, "sigma": 0.002,
//    "points": [{"force": 5.0, "stretch": 1.02}, …]}
//
// The tensile tests of a U3M 1.1 material: raw data of a FAB device, or a .u3m that names their
// file in material.physics.devices.fab, relative to itself. Strips of width 5 cm are stretched at a
// gauge of 8 cm (S2) along the length (L: warp), the width (W: weft) and the bias (B); their names
// are the file's with "_warp", "_weft" or "_bias". Their samples alternate distance [cm] and force
// [gf], cycle by cycle; the file is JSON with
//   "raw_data": {"B" | "L" | "W": {"S2": {"width" [cm], "samplesTree": [[d, f, d, f, …], …]}}}.
// The loading of each strip with the largest force counts. It begins where the strip is taut: its
// first sample is the rest length, its mean force over the first samples zero. The points are means
// of ten equal parts of the force. The readings' standard deviation is one hundredth of the largest
// strain, at least 1e-3: the file states none. The density is raw_data.M, or, before it,
// material.physics.weight of a .u3m, both in g/m². Other members (bending loops, thickness) are not
// read.
std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path);

}  // namespace drape
