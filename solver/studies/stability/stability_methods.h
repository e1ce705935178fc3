// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <memory>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/material.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/statics/statics.h"

namespace drape {

// Methods of one interface, to compare their limits. Two integrators are in production:
// MakeLinearlyImplicitEuler with StepLinearSolver::kDirect calls AdvanceOneStep
// (physics/simulation/rollout.h), the step of every rollout, and MakeImplicitEuler calls
// ImplicitEuler, the step of garments. The others exist for the atlas alone.

// Makes one step of h. After another status than kOk the state is not to be used.
using Integrator = std::function<IntegratorStatus(State& state)>;

// Semi-implicit (symplectic) Euler, handles as springs: v ← (v + h·M⁻¹·f)/(1 + h·drag),
// x ← x + h·v. It damps nothing by itself: drag [1/s] ≥ 0 is that of air. Stable for
// h < 2/ω·√(1 + h·drag/2), ω the highest frequency (HighestEigenvalue).
Integrator MakeExplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h, double drag);

// What solves the linear system of [MODEL, M30].
enum class StepLinearSolver {
  kDirect,  // MakeLinearSolver, as in production
  kPcg,     // conjugate gradients with incomplete Cholesky factors, both Eigen's
  kFloat    // state, matrix, right-hand side and factor (Eigen's LLT) in float; the elements are
            // evaluated in double at the rounded positions
};
struct PcgOptions {
  double tolerance = 1e-10;  // ‖b − A·v‖ ≤ tolerance·‖b‖
  int max_iterations = 500;
};
// The production step: one Newton iteration of implicit Euler, so one linear solve a step.
Integrator MakeLinearlyImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                                     const MaterialField& material, double h,
                                     StepLinearSolver solver, const PcgOptions& pcg = {});

// ImplicitEuler (physics/simulation/implicit_euler.h).
Integrator MakeImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h,
                             const ImplicitEulerOptions& options = {});

// Newton's method for a drape at rest by textbook means, which SolveEquilibrium does not use.

// K at x, the symmetric part of each element's stiffness cut to its positive semidefinite part
// [Teran 2005]: a StepMatrix, to be used with kNoShift.
void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K);

// EquilibriumOptions::shift of K as it is: where it is not positive definite there is no step.
inline constexpr StiffnessShift kNoShift = {
    .length = 0.0, .first = std::numeric_limits<double>::min(), .most = 0.0};

// Whether Newton's method gave up because K could not be factored. Exact under kNoShift, where each
// step is one factorisation.
inline bool EndedByFactorisation(const EquilibriumResult& result) {
  return result.status == EquilibriumStatus::kNotConverged &&
         result.factorisations == result.iterations + 1;
}

}  // namespace drape
