// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

// What one method did on one problem.
struct BenchmarkRecord {
  std::string problem;  // "synthetic_wool_7": image and count of parameters
  int parameters = 0;
  OptimiserRun run;
  Eigen::VectorXd shape;  // the drape of the least cost [m], shape [3V]; empty when none was found
  double rms_px = 0.0;    // its outline error
  double settled_rms_px = 0.0;  // the same after more steps from rest
  double drift = 0.0;           // largest displacement of a vertex in them [m]
  double stiffness = 0.0;       // lowest eigenvalue of K by mass [s⁻²]
};

// A record on disk, exact to the last bit. `settings` names all that shaped it. Throws InputError
// when it cannot be written.
void WriteBenchmarkRecord(const std::string& path, const std::string& settings,
                          const BenchmarkRecord& record);
// Nothing when there is no such file. Throws InputError for a file that is damaged or was made with
// other settings.
std::optional<BenchmarkRecord> ReadBenchmarkRecord(const std::string& path,
                                                   const std::string& settings);

}  // namespace drape
