// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/block_matrix.h"
#include "physics/cloth_model.h"

namespace drape {

// Sums of the element kernels over a cloth. x, w: [3V]. Everything about a step follows from
// g(x; w) = h·f(x) − h²·H(x)·w (SPEC section 4): the step solves (M + h²H)·v' = M·v + h·f.

// f(x) [N], shape [3V].
void AssembleForce(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                   Eigen::VectorXd& force);

// f(x) and A = M + h²·H(x) [kg].
void AssembleStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                  double h, Eigen::VectorXd& force, BlockMatrix& A);

// ∂g/∂x with w held. With w = 0 and h = 1 it is ∂f/∂x = −K, the exact stiffness of statics [N/m].
void AssembleStepDerivative(const ClothModel& model, const MaterialField& material,
                            const Eigen::VectorXd& x, const Eigen::VectorXd& w, double h,
                            BlockMatrix& derivative);

// Energy [J]: exact for gravity, handles, loads and bending; for stretch see StretchEnergy.
double Energy(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x);

}  // namespace drape
