// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// What a textile laboratory measures on a strip, as data of a fit.

enum class LabMeasurementKind {
  kCantilever,  // overhang length [m] → chord angle below the horizontal [°] [ASTM D1388]
  kTensile      // force [N] → stretch, length by rest length (strip method)
};
const char* ToString(LabMeasurementKind kind);

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
};

// A JSON file:
//   {"test": "cantilever", "direction": 0, "sigma": 1.0, "width": 0.025,
//    "points": [{"length": 0.06, "angle": 41.5}, …]}
//   {"test": "tensile", "direction": 90, "length": 0.2, "width": 0.05, "sigma": 0.002,
//    "points": [{"force": 5.0, "stretch": 1.02}, …]}
// `width` of a cantilever may be left out. Points may be in any order. Throws InputError (file,
// key, value, what was expected) for a key that is unknown or missing and a value out of range.
LabMeasurement ReadLabMeasurement(const std::string& path);
// Writes such a file atomically. Throws InputError.
void WriteLabMeasurement(const std::string& path, const LabMeasurement& measurement);

}  // namespace drape
