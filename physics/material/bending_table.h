// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/material/material.h"

namespace drape {

// Bending measurements of many fabrics as one CSV table, in the form of the data set published with
// [Feng 2022]: a line of column names, then one fabric a line, in any order of these columns:
//   density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear diag[SI*1e9],
//   nonlinear warp[SI*1e12], nonlinear weft[SI*1e12], nonlinear diag[SI*1e12]
// The moment by length of a curvature κ is M = B1 κ + B2 κ², with B1 = 1e-9 · linear [N·m] and
// B2 = 1e-12 · nonlinear [N·m²]. Such a table has no stretch.

// "table.csv#12:felt.json": row 12 of the table, with the stretch of felt.json.
struct BendingRow {
  std::string table, row;  // row: as the user wrote it; the first below the column names is 1
  std::string base;        // a material file (ReadMaterial); empty: none is named
};
// Returns nothing if the path names no row of a CSV file.
std::optional<BendingRow> SplitBendingRow(const std::string& path);

struct BendingMeasurement {
  double density = 0.0;  // [kg/m²]
  BendTable bend;
};
// Reads one row. The secant stiffness M/κ = B1 + B2 κ is a plate rigidity D, an entry is 4 D
// [MODEL, M8], and column k is that of the curvature 10 k /m, since the column is 0.1 κ
// [MODEL, M19, M26]:  bend[r][k] = 4 (B1 + 10 k B2). Rows are edge directions, and an edge along
// the weft bends the warp [MODEL, M8]: rows 0, 1, 2 are warp, diagonal, weft. From 40 /m on the
// table is constant, where the measured law is not. The measurements belong to directions of
// principal curvature; here, hinges of the edge directions share them. Throws InputError, naming
// the file and the line, for a column that is missing, a row that is not there, and a field that is
// no number; entries may be negative.
BendingMeasurement ReadBendingRow(const BendingRow& row);

}  // namespace drape
