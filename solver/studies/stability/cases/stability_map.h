// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/stability/cases/stability_case.h"

namespace drape {

// A method over two axes.
struct StabilityMap {
  std::string name;  // of its files: "explicit-time_step-stiffness", then what is set besides
  StabilityCase base;
  const StabilityAxis* axis[2] = {};  // across, up
  std::vector<double> values[2];      // ascending

  StabilityCase At(int i, int j) const;
  // Row by row: At(0, 0), At(1, 0), …
  std::vector<StabilityCase> Cases() const;
};

// One map for each method that a line names:
//   "step+implicit time_step=1e-4:0.5:9 stiffness=1e-3:1e3:7 density=0.1 law=reference"
// Values are a list "0/0.1/0.2", or "from:to:count", evenly spaced by ratio. Two axes have more
// than one value, the first is across; the others are set. Throws InputError, starting with
// `where`.
std::vector<StabilityMap> ParseStabilityMaps(const std::string& line, const std::string& where);

}  // namespace drape
