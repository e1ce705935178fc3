// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/simulation/rollout.h"
#include "solver/studies/validation/reference_case.h"

namespace drape {

// The groups of validation.h, for validation.cc only.
inline constexpr double kReferenceGravity = 9.81;  // [m/s²]

std::vector<ReferenceCase> RigidityCases();
std::vector<ReferenceCase> CantileverCases(const Law& law);
std::vector<ReferenceCase> TipLoadCases(const Law& law);
std::vector<ReferenceCase> HangingCases(const Law& law);
std::vector<ReferenceCase> UniaxialCases(const Law& law);
std::vector<ReferenceCase> ClampedDiscCases(const Law& law);
std::vector<ReferenceCase> AnnulusCases(const Law& law);
std::vector<ReferenceCase> RigidMotionCases(const Law& law);
std::vector<ReferenceCase> TurnCases(const Law& law);

// A reference case whose error is relative to its value.
ReferenceCase RelativeReference(std::string group, std::string name, double expected,
                                double tolerance);

// Moves x on to the equilibrium near it; fills it with NaN when there is none.
void GoToRest(StepSolver& solver, const MaterialField& material, Eigen::VectorXd& x);

}  // namespace drape
