// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/material/material.h"
#include "physics/simulation/implicit_euler.h"

namespace drape {

// Integrators behind one interface, to compare their limits. Two are in production:
// MakeLinearlyImplicitEuler with StepLinearSolver::kDirect calls AdvanceOneStep
// (physics/simulation/rollout.h), the step of every rollout, and MakeImplicitEuler calls
// ImplicitEuler, the step of garments. The others exist for the atlas alone.

class Integrator {
 public:
  virtual ~Integrator() = default;
  // One step of h. After another status than kOk the state is not to be used.
  [[nodiscard]] virtual IntegratorStatus Advance(State& state) = 0;
};

// Semi-implicit (symplectic) Euler, handles as springs: v ← (v + h·M⁻¹·f)/(1 + h·drag),
// x ← x + h·v. It damps nothing by itself: drag [1/s] ≥ 0 is that of air. Stable for
// h < 2/ω·√(1 + h·drag/2), ω the highest frequency (HighestEigenvalue).
std::unique_ptr<Integrator> MakeExplicitEuler(std::shared_ptr<const ClothModel> model,
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
std::unique_ptr<Integrator> MakeLinearlyImplicitEuler(std::shared_ptr<const ClothModel> model,
                                                      const MaterialField& material, double h,
                                                      StepLinearSolver solver,
                                                      const PcgOptions& pcg = {});

// ImplicitEuler (physics/simulation/implicit_euler.h).
std::unique_ptr<Integrator> MakeImplicitEuler(std::shared_ptr<const ClothModel> model,
                                              const MaterialField& material, double h,
                                              const ImplicitEulerOptions& options = {});

}  // namespace drape
