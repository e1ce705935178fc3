// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/simulation/statics/statics.h"

namespace drape {

// Newton's method for a drape at rest by textbook means, to compare with SolveEquilibrium
// (solver/studies/stability): statics uses neither.

// K at x, the symmetric part of each element's stiffness cut to its positive semidefinite part
// [Teran 2005].
void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K);

// SolveEquilibrium with that K instead of a shifted one; shape, radius and steps are judged alike.
EquilibriumResult SolveEquilibriumProjected(StepSolver& solver, const MaterialField& material,
                                            const Eigen::VectorXd& x,
                                            const EquilibriumOptions& options);

// For EquilibriumOptions::shift: K as it is; where it is not positive definite there is no step.
inline constexpr StiffnessShift kNoShift = {
    .length = 0.0, .first = std::numeric_limits<double>::min(), .most = 0.0};

// Newton gave up because K could not be factored with any shift. Exact under kNoShift and under
// projection, where each step is one factorisation.
inline bool EndedByFactorisation(const EquilibriumResult& result) {
  return result.status == EquilibriumStatus::kNotConverged &&
         result.factorisations == result.iterations + 1;
}

}  // namespace drape
