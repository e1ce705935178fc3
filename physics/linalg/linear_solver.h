// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "physics/linalg/block_matrix.h"

namespace drape {

// Direct solver of symmetric positive definite systems on one block pattern. The symbolic analysis
// is done once; clones share its result and factor independently. Not thread-safe.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Returns a copy with its own factor, for another thread.
  virtual std::unique_ptr<LinearSolver> Clone() const = 0;

  // Factors A = L·Lᵀ with A symmetric (one entry of each pair is read). Returns false when A is not
  // positive definite; the factor is then unusable.
  [[nodiscard]] virtual bool Factor(const BlockMatrix& A) = 0;

  // Solves in place, b ← A⁻¹·b, with shapes [3V] and [3V, m].
  virtual void Solve(Eigen::VectorXd& b) = 0;
  virtual void Solve(RowMatrix& b) = 0;

  // Copies the numbers of the present factor, for later solves (adjoint of a rollout). `saved`
  // keeps its memory when it already has the right size.
  virtual void SaveFactor(std::vector<double>& saved) const = 0;
  virtual void SolveSaved(const std::vector<double>& saved, RowMatrix& b) = 0;
  virtual std::size_t factor_bytes() const = 0;
};

// Makes a supernodal solver: nested dissection of the vertices [George 1973], symbolic analysis by
// CHOLMOD, factorisation and solves by SupernodalFactor.
std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern);

}  // namespace drape
