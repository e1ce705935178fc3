// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/material.h"

namespace drape {

// ∂r/∂x, shape [K, 3V].
using ReadoutJacobian = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// ∂r/∂p with x held: by the logarithms of the 39 table entries, then by the numbers of
// DynamicsEntry, shape [K, 46].
using MaterialJacobian = RowMatrix;

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
  // Whether r depends on the material too, so that dr_dp is filled by ReadCloth.
  virtual bool reads_material() const { return false; }
  // Computes r(x) of a shape x [m], shape [3V], in shape [K], and its Jacobian unless dr_dx is
  // null. Returns false where the shape cannot be read. May be called from several threads at a
  // time.
  [[nodiscard]] virtual bool Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                                  ReadoutJacobian* dr_dx) const = 0;
  // Reads a cloth of one table, on which most readouts do not depend: their dr_dp stays empty.
  // Readouts that do cannot read a shape alone.
  [[nodiscard]] virtual bool ReadCloth(const MaterialField&, const Eigen::VectorXd& x,
                                       Eigen::VectorXd* r, ReadoutJacobian* dr_dx,
                                       MaterialJacobian*) const {
    return Read(x, r, dr_dx);
  }
};

}  // namespace drape
