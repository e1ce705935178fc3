// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/cloth/assembly/material_sensitivity.h"
#include "physics/cloth/assembly/step_solver.h"
#include "physics/simulation/statics/newton_control.h"

namespace drape {

// Drapes at rest, f(x) = 0, and their derivatives by the implicit function theorem
// [MODEL, M33, M43], with the exact K = −∂f/∂x of Stiffness.

struct EquilibriumResult {
  EquilibriumStatus status = EquilibriumStatus::kNotConverged;
  Eigen::VectorXd x;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      // ‖f‖ / weight, the latter by CharacteristicForce
  double start_energy = 0.0;  // [J]
  std::vector<NewtonStep> steps;
};

// The weight of the cloth [N], by which residuals and tolerances are relative; a cloth without
// gravity is weighed at 9.8 m/s².
double CharacteristicForce(const ClothModel& model, const MaterialField& material);

// Newton's method from x. Start near the drape, never from flat: many drapes are stable and this
// finds a near one.
// - The geometric stiffness is that of the stress extrapolated along the step before, as in a mixed
//   method with stresses of their own [Magisano 2017]: a finite rotation stretches x + dx by
//   ½|dx|², and the stress of that would stop the next step. It goes 3–5 times as far in a step.
// - So a step may raise the energy and the next ones lower it again: steps that do not within eight
//   are taken back and the radius is shortened (watchdog [Chamberlain 1982]).
// - K is shifted until it is positive definite.
EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options);

// ∂x/∂p = K⁻¹·∂f/∂p at an equilibrium for the 39 entries, weighted as in AddMaterialColumns; shape
// [3V, 39]. False when K is not positive definite or Stiffness::Solve does not converge.
[[nodiscard]] bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                                      const MaterialField& weight, const Eigen::VectorXd& x,
                                      RowMatrix* dx);

// dx = K⁻¹·∂f/∂p·change: how an equilibrium moves with the tables, to first order in a change of
// each entry. One column of EquilibriumTangent's kind; false as there.
[[nodiscard]] bool EquilibriumJvpColumn(StepSolver& solver, const MaterialField& material,
                                        const MaterialField& change, const Eigen::VectorXd& x,
                                        Eigen::VectorXd* dx);

// Gradients of m scalars L of an equilibrium by each entry of the material's tables, with seeds
// ∂L/∂x, shape [3V, m]: (∂f/∂p)ᵀ·K⁻ᵀ·seeds by one factorisation. False as in EquilibriumTangent.
[[nodiscard]] bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material,
                                      const Eigen::VectorXd& x, const RowMatrix& seeds,
                                      MaterialGradient* gradient);

// ‖f(x)‖ / weight, as in EquilibriumResult: how far from rest a shape is.
double ForceResidual(const ClothModel& model, const MaterialField& material,
                     const Eigen::VectorXd& x);

}  // namespace drape
