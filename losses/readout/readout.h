// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace drape {

// ∂r/∂x, shape [K, 3V].
using ReadoutJacobian = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The numbers that a loss reads from a shape of a cloth.
class Readout {
 public:
  virtual ~Readout() = default;
  // K, which is the same for all shapes.
  virtual int size() const = 0;
  // How many rows in sequence are of one thing, which a robust loss takes as a whole: 3 where they
  // are the coordinates of a point. Divides K.
  virtual int group() const { return 1; }
  // How many of the K numbers are independent near a fit: what a χ² counts.
  virtual int num_independent() const { return size(); }
  // Computes r(x) of a shape x [m], shape [3V], in shape [K], and its Jacobian unless dr_dx is
  // null. Returns false where the shape cannot be read. May be called from several threads at a
  // time.
  [[nodiscard]] virtual bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                                  ReadoutJacobian* dr_dx) const = 0;
};

}  // namespace drape
