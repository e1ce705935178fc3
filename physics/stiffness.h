// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/assembly.h"
#include "physics/rollout.h"

namespace drape {

// A positive shift of a stiffness, μ·(M + ℓ²·L) with the lumped mass M and L = ∫ρ·∇φ·∇φ: ‖u‖² and
// ℓ²·‖∇u‖² weighed by density. ℓ > 0 holds wrinkles, which are what is mostly unstable in a falling
// cloth, and leaves its soft wide motions free, which a mass shift (ℓ = 0) as large would stop.
struct StiffnessShift {
  double length = 0.0;  // ℓ [m]
  double first = 25.0;  // smallest μ > 0; it grows by factors of 4 [s⁻²]
  double most = 1e8;    // gives up above
};

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
  // Factors Ks + shift, μ = *mu [s⁻²] or the first larger one that makes it positive definite.
  // False when none does. `tries`, when given, is raised by each factorisation.
  [[nodiscard]] bool FactorShifted(const StiffnessShift& shift, double* mu, int* tries = nullptr);

  // Solves K·solution = rhs, or Kᵀ·solution = rhs, each column to 1e-10 of its rhs, or to rounding
  // (at most 1e-6) where a slender strip is so much stiffer in its plane than across it that
  // products with K lose more; shapes [3V, m]. Needs Factor(). False when it does not converge.
  // Concus & Golub 1976, Widlund 1978: K = Ks + skew part, so the conjugate gradients of Ks⁻¹·K
  // need a recurrence of three terms only.
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
