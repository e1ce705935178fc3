// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
#include <string>

#include "physics/material_io.h"

namespace drape {

// The tables of the published start materials that the smooth law refuses have negative entries:
// raised to a hundredth of the largest.
inline void RaiseEntries(std::span<double> entries) {
  const double least = 0.01 * *std::max_element(entries.begin(), entries.end());
  for (double& entry : entries) entry = std::max(entry, least);
}
inline MaterialField ReadFabric(const std::string& path) {
  MaterialField field = ReadMaterial(path, {NegativeEntries::kWarn}).field;
  RaiseEntries({&field.stretch[0].c[0][0], kStretchEntries});
  RaiseEntries({&field.bend[0].b[0][0], kBendEntries});
  return field;
}

}  // namespace drape
