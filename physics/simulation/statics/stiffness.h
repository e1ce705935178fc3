// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <optional>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/step_solver.h"

namespace drape {

// The random start vector of Stiffness::Asymmetry, shape [dofs, 1], and the number of
// multiplications.
RowMatrix AsymmetryStart(int dofs);
inline constexpr int kAsymmetryRounds = 8;

// K = −∂f/∂x of a cloth in equilibrium and a factor of its symmetric part Ks [MODEL, M33]. K is
// slightly unsymmetric because a stretch table is in general not the gradient of an energy.
class Stiffness {
 public:
  // Both arguments must outlive the object; the factor is kept in solver.linear(), which Assemble
  // replaces where new pairs of the cloth touch.
  Stiffness(StepSolver& solver, const MaterialField& material);

  // Assembles K at x.
  void Assemble(const Eigen::VectorXd& x);
  // Assembles Ks alone (AssembleStiffness): for Factor and FactorShifted, until the next Assemble.
  void AssembleSymmetric(const ElementStates& states, const StressField& stress,
                         const Eigen::VectorXd& x, StiffnessPart part);
  // Assembles instead of K the positive semidefinite H of a linearly implicit step [MODEL, M30]:
  // for Factor alone, until the next Assemble.
  void AssemblePositive(const Eigen::VectorXd& x);
  // Adds a block to Ks at the vertices (i, j) and, if these differ, its transpose at (j, i), until
  // the next Assemble [N/m]. Returns false where the pattern has no such block.
  [[nodiscard]] bool AddBlock(int i, int j, const Eigen::Matrix3d& block);

  // Factors Ks. Returns false when it is not positive definite.
  [[nodiscard]] bool Factor();
  // Factors Ks + μ·(M + ℓ²·L) of StiffnessShift [MODEL, M35] with ℓ = `length` [m] and μ = *mu
  // [s⁻²]. While the factorisation fails, `next` receives the μ that failed and returns a larger
  // one. Returns false when `next` returns std::nullopt.
  [[nodiscard]] bool FactorShifted(double length, double* mu,
                                   const std::function<std::optional<double>(double failed)>& next);

  // Solves K·solution = rhs or Kᵀ·solution = rhs, each column to the accuracy of CgwRecurrence
  // [MODEL, M44]; shapes [3V, m]. Requires a successful Factor(). Returns false when it does not
  // converge.
  [[nodiscard]] bool Solve(const RowMatrix& rhs, RowMatrix* solution);
  [[nodiscard]] bool SolveTransposed(const RowMatrix& rhs, RowMatrix* solution);

  // A measure of the asymmetry of K: the growth of a random vector under Ks⁻¹·(K − Ks),
  // approximately its spectral radius [MODEL, M36]. Requires a successful Factor().
  double Asymmetry();

 private:
  BlockMatrix& Symmetric();  // symmetric_, of the present pattern
  bool SolveWith(decltype(AddMultiply)& multiply, const RowMatrix& rhs, RowMatrix* solution);

  StepSolver& solver_;
  const MaterialField& material_;
  MaterialField weightless_;
  const BlockMatrix* negative_ = nullptr;  // −K
  BlockMatrix symmetric_;                  // Ks
};

// The `count` lowest eigenvalues ω² [s⁻²], ascending, of ½(K + Kᵀ)·φ = ω²·M·φ at x, with the exact
// K = −∂f/∂x and the lumped mass M [MODEL, M36]. They are the squared angular frequencies of small
// vibrations; the lowest is negative where x is unstable. The result is empty when the iteration
// does not converge. 1 ≤ count < 3V. The method is Spectra's Lanczos iteration on (K + μM)⁻¹, with
// μ the shift that makes K + μM positive definite. Empty soon after *cancel turns true, which may
// be null.
Eigen::VectorXd LowestEigenvalues(StepSolver& solver, const MaterialField& material,
                                  const Eigen::VectorXd& x, int count,
                                  const std::atomic<bool>* cancel = nullptr);

// Eigenvalues with their shapes φ, shape [3V, count], φᵀ·M·φ = 1. Both are empty if the iteration
// does not converge.
struct VibrationModes {
  Eigen::VectorXd eigenvalues;  // ω² [s⁻²], ascending
  Eigen::MatrixXd shapes;       // [kg^-½]
};
VibrationModes LowestModes(StepSolver& solver, const MaterialField& material,
                           const Eigen::VectorXd& x, int count);

// Change of the eigenvalue φᵀ·K·φ of a mode that is apart from the others [MODEL, M67]: by x
// under the same material, and by the tables at the same x. By the density, on which K does not
// depend, it is −ω²/ρ.
struct EigenvalueGradient {
  Eigen::VectorXd by_x;          // [s⁻²/m], shape [3V]
  MaterialGradient by_material;  // one column
};
// shape: φ of LowestModes. By central differences of K along φ, which are accurate to 1e-6.
EigenvalueGradient DeriveEigenvalue(StepSolver& solver, const MaterialField& material,
                                    const Eigen::VectorXd& x, const Eigen::VectorXd& shape);

// The largest ω² [s⁻²] to 1e-6: an explicit step is stable for h < 2/ω [Courant 1928],
// [MODEL, M32]. std::nullopt when the iteration does not converge.
std::optional<double> HighestEigenvalue(StepSolver& solver, const MaterialField& material,
                                        const Eigen::VectorXd& x);

// True when there are eigenvalues and all of them are positive by more than rounding [MODEL, M36].
inline bool IsStable(const Eigen::VectorXd& lowest_eigenvalues) {
  constexpr double kRounding = 1e-6;  // [s⁻²]
  return lowest_eigenvalues.size() > 0 && lowest_eigenvalues[0] > kRounding;
}

}  // namespace drape
