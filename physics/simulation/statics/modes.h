// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>

#include "physics/cloth/assembly/step_solver.h"

namespace drape {

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
