// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/rollout.h"

namespace drape {

// Drapes at rest, f(x) = 0, and their derivatives by the implicit function theorem (SPEC section 4,
// `static`). K = −∂f/∂x is slightly unsymmetric because a stretch table is in general not the
// gradient of an energy: its symmetric part is factored, solutions are refined to K itself.

struct EquilibriumOptions {
  double tolerance = 1e-9;      // ‖f‖ ≤ tolerance × weight
  int max_iterations = 100;     // Newton steps
  double first_shift = 25.0;    // μ of K + μM where K is not positive definite [s⁻²]
  double max_shift = 1e8;       // gives up above
  double max_move = 0.03;       // longest move of a vertex in one step [m]
  // ‖f‖ / weight below which a step may also lower ‖f‖ instead of the energy. Under a load that
  // strains a nonlinear table by percents, no energy has its minimum at the equilibrium: infinity.
  double residual_regime = 1e-3;
  const std::atomic<bool>* cancel = nullptr;
};

enum class EquilibriumStatus {
  kStable,        // converged, K positive definite
  kUnstable,      // converged, but K has lost definiteness or its unsymmetric part rules: at or past
                  // a fold bifurcation, where derivatives blow up
  kNotConverged,  // iteration limit, or no step lowers energy or residual
  kCancelled
};
const char* ToString(EquilibriumStatus status);

// One Newton step.
struct NewtonStep {
  double residual;  // ‖f‖ / weight before the step
  double energy;    // after it [J]
  double shift;     // μ that was factored [s⁻²]
  int halvings;     // of the step by the line search; −1: no step was accepted
};

struct EquilibriumResult {
  EquilibriumStatus status = EquilibriumStatus::kNotConverged;
  Eigen::VectorXd x;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;  // ‖f‖ / weight; a cloth without gravity is weighed at 9.8 m/s²
  double start_energy = 0.0;  // [J]
  std::vector<NewtonStep> steps;
};

// Newton from x on the symmetrised exact K, shifted by the mass matrix until it is positive
// definite, with a line search on the energy. Start near the drape, never from flat: many drapes
// are stable and this finds a near one.
EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options);

// ∂x/∂p = K⁻¹·∂f/∂p at an equilibrium for the 39 entries, weighted as in AddMaterialColumns; shape
// [3V, 39]. False when K is not positive definite or the refinement to 1e-10 does not contract.
[[nodiscard]] bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                                      const MaterialField& weight, const Eigen::VectorXd& x,
                                      RowMatrix* dx);

// Gradients of m scalars L of an equilibrium by each entry of the material's tables, with seeds
// ∂L/∂x, shape [3V, m]: (∂f/∂p)ᵀ·K⁻ᵀ·seeds by one factorisation. False as in EquilibriumTangent.
[[nodiscard]] bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material,
                                      const Eigen::VectorXd& x, const RowMatrix& seeds,
                                      MaterialGradient* gradient);

// Factors ½(K + Kᵀ) + μM at x in solver.linear(), μ = *shift [s⁻²] the first of EquilibriumOptions'
// schedule (0 first) that makes it positive definite. False when none does.
[[nodiscard]] bool FactorStiffness(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, double* shift);

// ‖f(x)‖ / weight, as in EquilibriumResult: how far from rest a shape is.
double ForceResidual(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x);

}  // namespace drape
