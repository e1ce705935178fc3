// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

struct ReferenceCase {
  std::string group;  // one of ValidationGroups()
  std::string name;   // what is measured, with its unit
  double expected = 0.0;
  double tolerance = 0.0;        // of Error() at the finest mesh
  std::vector<double> computed;  // coarse to fine, each half as wide as the one before; NaN where
                                 // no equilibrium was found
  double scale = 0.0;            // Error() = |computed − expected| / scale

  double Error() const;
  bool Holds() const;  // false for NaN
  // log2 of the ratio of two successive changes: p of an error h^p. NaN when the changes are
  // rounding (the meshes agree) or do not shrink in one direction.
  double Order() const;
};

}  // namespace drape
