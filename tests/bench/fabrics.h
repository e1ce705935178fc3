// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

#include "physics/material/material_io.h"

namespace drape {

// Replaces negative entries, which published tables have and the smooth law rejects, by a tenth of
// the largest entry of their column.
inline void RaiseNegativeEntries(double* table, int rows, int columns) {
  for (int c = 0; c < columns; ++c) {
    double largest = 0.0;
    for (int r = 0; r < rows; ++r) largest = std::max(largest, table[columns * r + c]);
    for (int r = 0; r < rows; ++r)
      if (table[columns * r + c] < 0.0) table[columns * r + c] = 0.1 * largest;
  }
}
inline MaterialField ReadFabric(const std::string& path) {
  MaterialField field = ReadMaterial(path, {NegativeEntries::kWarn}).field;
  RaiseNegativeEntries(&field.stretch[0].c[0][0], kStretchRows, kStretchCols);
  RaiseNegativeEntries(&field.bend[0].b[0][0], kBendRows, kBendCols);
  return field;
}

}  // namespace drape
