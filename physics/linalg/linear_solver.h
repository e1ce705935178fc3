// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "physics/linalg/block_matrix.h"

namespace drape {

// Direct solver of symmetric positive definite systems on one block pattern. The symbolic analysis
// is done once; clones share its result and factor on their own. Not thread-safe.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // A copy with its own numbers, for another thread.
  virtual std::unique_ptr<LinearSolver> Clone() const = 0;

  // A = L·Lᵀ, A symmetric (one entry of each pair is read). False when A is not positive definite;
  // the factor is then unusable.
  [[nodiscard]] virtual bool Factor(const BlockMatrix& A) = 0;

  // In place, b ← A⁻¹·b; shapes [3V] and [3V, m].
  virtual void Solve(Eigen::VectorXd& b) = 0;
  virtual void Solve(RowMatrix& b) = 0;

  // The numbers of the present factor, to be solved with later (adjoint of a rollout). `saved`
  // keeps its memory when it has the size already.
  virtual void SaveFactor(std::vector<double>& saved) const = 0;
  virtual void SolveSaved(const std::vector<double>& saved, RowMatrix& b) = 0;
  virtual std::size_t factor_bytes() const = 0;
};

// Supernodal: a nested dissection of the vertices, CHOLMOD's symbolic analysis, factorisation and
// solves by SupernodalFactor.
std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern);

}  // namespace drape
