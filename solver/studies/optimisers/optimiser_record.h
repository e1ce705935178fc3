// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/fit_types.h"
#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

// What one method did on one problem.
struct BenchmarkRecord {
  std::string problem;  // "synthetic_wool_7": image and count of parameters
  int parameters = 0;
  int seed = 0;  // of a method that draws random numbers
  OptimiserRun run;
  Eigen::VectorXd shape;  // the drape of the least cost [m], shape [3V]; empty when none was found
  double rms_px = 0.0;    // its outline error
  double settled_rms_px = 0.0;  // the same where it comes to rest when nudged (Nudge)
  double drift = 0.0;           // largest displacement of a vertex by that [m]
  double coupling = 0.0;        // LargestSquaredCoupling of its table
  double stiffness = 0.0;       // lowest eigenvalue of K by mass [s⁻²]
};

// What a record on disk must be of. References outlive the object.
struct ExpectedRecord {
  std::string settings;  // names all that shaped the run
  std::string problem, method;
  int seed = 0;
  double most_spent = 0.0;  // of the budget
  const FitProblem& fit;    // of one observation
  StagedFitOptions stages;  // with the parameters of the problem
  InitialGuess guess;       // that the method started from
};

inline constexpr StoredFormat kRecordFormat = {"drapefit-optimiser-run", 5};

// A record on disk, exact to the last bit. Throws InputError when it cannot be written.
void WriteBenchmarkRecord(const std::string& path, const std::string& settings,
                          const BenchmarkRecord& record);
// Nothing when there is no such file. Throws InputError, which names the file and the key, for a
// file that is damaged, was made with other settings, or says what such a run cannot have found:
// another problem or method, other sizes, values out of range, costs that do not fall, a drape
// that CheckCandidate refuses.
std::optional<BenchmarkRecord> ReadBenchmarkRecord(const std::string& path,
                                                   const ExpectedRecord& expected);

}  // namespace drape
