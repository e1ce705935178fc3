// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/step_solver.h"

namespace drape {

// The random vector of Stiffness::Asymmetry, shape [dofs, 1], and how often it is multiplied.
RowMatrix AsymmetryStart(int dofs);
inline constexpr int kAsymmetryRounds = 8;

// K = −∂f/∂x of a cloth at rest and a factor of its symmetric part Ks. K is slightly unsymmetric
// because a stretch table is in general not the gradient of an energy.
class Stiffness {
 public:
  // References outlive the object; the factor is kept in solver.linear().
  Stiffness(StepSolver& solver, const MaterialField& material);

  // K at x.
  void Assemble(const Eigen::VectorXd& x);
  // Adds the geometric stiffness of a change of stress to Ks, until the next Assemble.
  void AddStress(const StressField& change);

  // Factors Ks. False when it is not positive definite.
  [[nodiscard]] bool Factor();
  // Factors Ks + μ·(M + ℓ²·L) of StiffnessShift with μ = *mu [s⁻²] or, until it is positive
  // definite, the larger ones that `next` names after that which failed. False when it names none.
  [[nodiscard]] bool FactorShifted(double length, double* mu,
                                   const std::function<std::optional<double>(double failed)>& next);

  // Solves K·solution = rhs, or Kᵀ·solution = rhs, each column to the accuracy of CgwRecurrence;
  // shapes [3V, m]. Needs Factor(). False when it does not converge.
  [[nodiscard]] bool Solve(const RowMatrix& rhs, RowMatrix* solution);
  [[nodiscard]] bool SolveTransposed(const RowMatrix& rhs, RowMatrix* solution);

  // How far from symmetric K is: the growth of a random vector under Ks⁻¹·(K − Ks), about its
  // spectral radius. Needs Factor().
  double Asymmetry();

 private:
  bool SolveWith(decltype(AddMultiply)& multiply, const RowMatrix& rhs, RowMatrix* solution);

  StepSolver& solver_;
  const MaterialField& material_;
  const BlockMatrix* negative_ = nullptr;  // −K
  BlockMatrix symmetric_;                  // Ks
};

}  // namespace drape
