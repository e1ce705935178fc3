// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "physics/cloth/assembly/step_solver.h"
#include "physics/simulation/statics/newton_control.h"

namespace drape {

// Equilibria of the cloth, f(x) = 0, and their derivatives by the implicit function theorem
// [MODEL, M33, M43], with the exact K = −∂f/∂x of Stiffness.

struct EquilibriumResult {
  EquilibriumStatus status = EquilibriumStatus::kNotConverged;
  Eigen::VectorXd x;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      // ‖f‖ / weight, with the weight of CharacteristicForce
  double start_energy = 0.0;  // [J]
  double load_share = 1.0;    // of the load that x carries; less than 1: SolveFromRest ended there
  std::vector<NewtonStep> steps;
};

// The weight of the cloth [N], to which residuals and tolerances are relative. A scene without
// gravity uses 9.8 m/s² [MODEL, M33].
double CharacteristicForce(const ClothModel& model, const MaterialField& material);

// Assembles at x the matrix that a Newton step factors instead of K, which is then never shifted.
using StepMatrix = std::function<void(const Eigen::VectorXd& x, BlockMatrix& matrix)>;

// Newton's method from x, shape [3V] [MODEL, M34–M37]. Start near the drape, never from the flat
// cloth: a drape has many stable equilibria, and this finds a near one.
// - The geometric stiffness uses the stress extrapolated along the previous step, as in a
//   mixed method with stresses as unknowns [Magisano 2017]: a finite rotation strains x + dx by
//   ½|dx|², and the stress of that would stop the next step. Steps become 3–5 times as long.
// - A step may therefore raise the energy, and the next ones lower it again. Steps that do not do
//   so within eight are rejected, and the radius is shortened (watchdog [Chamberlain 1982]).
// - K is shifted until it is positive definite.
// Where the scene has contact of the cloth with itself, no step passes through it; a start that
// does (FindSelfOverlap) is returned as not converged. matrix: of the steps; none: K.
EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options,
                                   const StepMatrix& matrix = {});

// ∂x/∂p = K⁻¹·∂f/∂p at an equilibrium for the 39 entries, weighted as in AddMaterialColumns; shape
// [3V, 39] [MODEL, M43]. Returns false when K is not positive definite or Stiffness::Solve does not
// converge.
[[nodiscard]] bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                                      const MaterialField& weight, const Eigen::VectorXd& x,
                                      RowMatrix* dx);

// dx = K⁻¹·∂f/∂p·change: the displacement of an equilibrium, to first order in a change of each
// table entry. It has the shape [3V] of one column of EquilibriumTangent. Returns false as
// EquilibriumTangent does.
[[nodiscard]] bool EquilibriumJvpColumn(StepSolver& solver, const MaterialField& material,
                                        const MaterialField& change, const Eigen::VectorXd& x,
                                        Eigen::VectorXd* dx);

// Gradients of m scalars L of an equilibrium by each entry of the tables of the material, from
// dL_dx = ∂L/∂x, shape [3V, m]: (∂f/∂p)ᵀ·K⁻ᵀ·dL_dx by one factorisation [MODEL, M43]. Returns false
// as EquilibriumTangent does.
[[nodiscard]] bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material,
                                      const Eigen::VectorXd& x, const RowMatrix& dL_dx,
                                      MaterialGradient* gradient);

// ‖f(x)‖ / weight, as in EquilibriumResult: the distance of a shape from equilibrium.
double ForceResidual(const ClothModel& model, const MaterialField& material,
                     const Eigen::VectorXd& x);

}  // namespace drape
