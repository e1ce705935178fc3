// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/rollout.h"
#include "physics/validation.h"

namespace drape {

// The groups of validation.h, for validation.cc only.
inline constexpr double kTruthGravity = 9.81;  // [m/s²]

std::vector<Truth> RigidityTruths();
std::vector<Truth> CantileverTruths(const Law& law);
std::vector<Truth> TipLoadTruths(const Law& law);
std::vector<Truth> HangingTruths(const Law& law);
std::vector<Truth> UniaxialTruths(const Law& law);
std::vector<Truth> ClampedDiscTruths(const Law& law);
std::vector<Truth> RigidTruths(const Law& law);
std::vector<Truth> TurnTruths(const Law& law);

// A truth whose error is relative to its value.
Truth RelativeTruth(std::string group, std::string name, double expected, double tolerance);

// Moves x on to the equilibrium near it; fills it with NaN when there is none.
void GoToRest(StepSolver& solver, const MaterialField& material, Eigen::VectorXd& x);

}  // namespace drape
