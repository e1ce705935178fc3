// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/cloth/assembly/material_sensitivity.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

// Adjoint of the step force g(x; w) of assembly.h for one λ, shape [3V, 1], element by element: no
// matrix is assembled, and geometry and law are evaluated once for both results [MODEL, M42].
//   adj_x += (∂g/∂x)ᵀ·λ with w held, shape [3V, 1];  gradient += (∂g/∂entry)ᵀ·λ, one column.
// For many λ, AssembleStepDerivative with AddTransposeMultiply and AddMaterialGradient costs less.
void AdjStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
             const Eigen::VectorXd& w, double h, const RowMatrix& lambda, RowMatrix& adj_x,
             MaterialGradient& gradient);

}  // namespace drape
