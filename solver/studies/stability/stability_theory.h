// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "solver/studies/stability/stability_runner.h"

namespace drape {

// What theory says of a case, and what is measured of the same.

// Largest stable time step of the explicit method [s].
struct ExplicitLimit {
  // [Courant 1928]: ω²h² = 4 + 2·h·drag, with ω of HighestEigenvalue at rest.
  std::optional<double> theory;
  // By bisection to 3 %: from the case's own start the cloth is not lost (IsLost) in `steps` steps.
  std::optional<double> measured;
};
ExplicitLimit MeasureLimit(const StabilityRunner& runner, StabilityCase run, int steps = 1500);

// By how much a step of an implicit method shrinks a small vibration about the drape at rest, in
// the norm of its energy: mode number `mode` of LowestModes, followed for some steps. Implicit
// Euler's factor is 1/√(1 + h²ω²) [Hairer 1996, IV.3], an exact oscillator's is 1.
struct StepDamping {
  double omega = 0.0;     // [1/s]
  double theory = 0.0;    // of implicit Euler
  double measured = 0.0;  // a step, the mean of `steps`
  int steps = 0;
};
// None where the case has no stable drape or its method fails.
std::optional<StepDamping> MeasureDamping(StabilityRunner& runner, const StabilityCase& run,
                                          int mode);

}  // namespace drape
