// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/fit/fit.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// The factor on sigma (Experiment::mesh_factor, step_factor) above which the material explains the
// error of a motion's grid: it is not corrected, and the fit is not to be used [METHODS, P75].
inline constexpr double kMostGridFactor = 5.0;

// Fits laboratory measurements and motions alone: few parameters first, since far from the solution
// single entries are changed into tables that no strip resists. First scales about the start
// tables; the prior of what follows is about the tables so scaled, as after the initial guesses of
// a silhouette. The result is that of the last stage that succeeds; `note` says why a later one did
// not. Cloth that moves is fitted from several scales of the start tables, and again as far as mesh
// and time step err: its experiments get grid_error, mesh_factor and step_factor [METHODS, P75].
// The Jacobians of motions are for intervals (ForIntervals).
FitSummary FitLabInStages(ParameterTying last, const FitOptions& options, FitProblem& problem,
                          std::string* note);

}  // namespace drape
