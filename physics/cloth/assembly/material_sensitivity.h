// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/cloth/cloth_model.h"
#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// Derivatives of the step force g(x; w) = h·f(x) − h²·H(x)·w of assembly.h by the material tables
// [MODEL, M40].

// columns += ∂g/∂entry · weight for the 39 table entries of all elements at once, shape [3V, 39]
// (24 stretch entries row-major, then 15 bend entries); further columns are left unchanged.
// `weight` holds a number for each entry: ones for the derivative by the entry itself, the material
// for that by its logarithm, any field for a directional derivative.
void AddMaterialColumns(const ClothModel& model, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x,
                        const Eigen::VectorXd& w, double h, RowMatrix& columns);

// Gradients of m scalars by each table entry of a material field of one table for the whole cloth
// or one for each element.
struct MaterialGradient {
  RowMatrix stretch;  // [24·(1 or F), m]
  RowMatrix bend;     // [15·(1 or E), m]

  static MaterialGradient Zero(const MaterialField& like, int m);
  // Σ entry gradient × weight over all elements, shape [39, m], in the order of the columns of
  // AddMaterialColumns.
  RowMatrix Contract(const MaterialField& weight) const;
};

// gradient += (∂g/∂entry)ᵀ·lambda, the adjoint of AddMaterialColumns entry by entry; lambda has
// shape [3V, m].
void AddMaterialGradient(const ClothModel& model, const MaterialField& material,
                         const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                         const RowMatrix& lambda, MaterialGradient& gradient);

}  // namespace drape
