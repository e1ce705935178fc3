// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// Settings with the error that a user may expect of them: what --accuracy picks from. All of them
// end in a drape at rest. Made by drape_bench from runs with several fabrics, kept in
// configs/accuracy.json.

// The error is that of the radius of the circle of the silhouette's area, so that of the drape
// coefficient as a length, against an infinitely fine mesh. Not of the outline angle by angle:
// folds turn about the support by centimetres from mesh to mesh, at next to no energy.
struct AccuracyRow {
  std::string mesh;        // ParseMeshSpec
  std::string integrator;  // dynamic or hybrid
  double h = 0.1;          // time step [s]
  int steps = 100;
  double error_mm = 0.0;  // promised: the largest of the table's fabrics, with its error margin
  // What showed that the drapes are at rest (kAtRestResidual, kAtRestDrift), the largest of the
  // fabrics: forces that remain, by the weight; movement of a vertex once it is released.
  double residual = 0.0, drift_mm = 0.0;
  double cost = 0.0;  // time by that of the row "exact"
};

struct AccuracyTable {
  std::string made_on;            // fabrics, seed and references, for a person
  std::vector<AccuracyRow> rows;  // of each integrator those that no other beats, fastest first
  // Errors of the named levels [mm].
  double fast = 0.0, balanced = 0.0, exact = 0.0;

  // The cheapest row of an allowed integrator ("" allows both) whose error is within `accuracy`:
  // "fast", "balanced", "exact" or a length such as "0.5mm". Throws InputError for any other text,
  // for less than the table has, and for an integrator without a row.
  const AccuracyRow& Pick(const std::string& accuracy, const std::string& integrator) const;
};

// Reads a table of JSON. Throws InputError, prefix `where`, also for a number out of the range of
// the option that it sets, and for a row whose drapes were not at rest.
AccuracyTable ParseAccuracyTable(const std::string& text, const std::string& where);

}  // namespace drape
