// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/cloth/cloth_model.h"
#include "physics/linalg/block_matrix.h"

namespace drape {

// How the step force g(x; w) = h·f(x) − h²·H(x)·w of assembly.h follows the material tables.

// columns += ∂g/∂entry · weight for the 39 table entries of all elements at once, shape [3V, 39] or
// wider, the other columns untouched (24 stretch entries row-major, then 15 bend entries). `weight`
// holds a number for each entry: ones for the entry itself, the material for its logarithm, any
// field for a directional derivative.
void AddMaterialColumns(const ClothModel& model, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x,
                        const Eigen::VectorXd& w, double h, RowMatrix& columns);

// Gradients of m scalars by each table entry of a material field: one table (HOMO) or one each
// element.
struct MaterialGradient {
  RowMatrix stretch;  // [24·(1 or F), m]
  RowMatrix bend;     // [15·(1 or E), m]

  static MaterialGradient Zero(const MaterialField& like, int m);
  // Σ entry gradient × weight over all elements: shape [39, m], as AddMaterialColumns' columns.
  RowMatrix Contract(const MaterialField& weight) const;
};

// gradient += (∂g/∂entry)ᵀ·lambda, the adjoint of AddMaterialColumns entry by entry; lambda [3V,
// m].
void AddMaterialGradient(const ClothModel& model, const MaterialField& material,
                         const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                         const RowMatrix& lambda, MaterialGradient& gradient);

}  // namespace drape
