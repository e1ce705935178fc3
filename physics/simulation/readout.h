// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>

namespace drape {

// ∂r/∂x, shape [K, 3V].
using ReadoutJacobian = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The numbers that a loss reads from the shapes of a batch: K numbers of each shape.
class Readout {
 public:
  virtual ~Readout() = default;
  // K, which is the same for all rollouts.
  virtual int size() const = 0;
  // Computes r(x) of a shape x [3V] of rollout i, shape [K], and its Jacobian unless dr_dx is null.
  // Returns false where the shape cannot be read. May be called from several threads at a time.
  [[nodiscard]] virtual bool Read(std::size_t i, const Eigen::VectorXd& x, Eigen::VectorXd* r,
                                  ReadoutJacobian* dr_dx) const = 0;
};

}  // namespace drape
