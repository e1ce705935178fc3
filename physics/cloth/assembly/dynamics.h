// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/cloth/cloth_model.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/material.h"

namespace drape {

// A step of a moving cloth, with the damping and the air of MaterialField::dynamics [MODEL, M64,
// M65]:
//   A·w = M·v + g(x, v), A = (1 + hα)·M + h²·H + hβ·H of the elements + air.
// Damping is in AssembleStep, and in all derivatives at held w through DampedVelocity.

struct MovingStep {
  const Eigen::VectorXd &x, &v;  // before it, shape [3V] each
  const Eigen::VectorXd& w;      // v', shape [3V]
  double h;
};

// force += push of the wind [N] and A += the air's part, which is in the diagonal blocks [kg]; v:
// before the step.
void AddAirStep(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x,
                const Eigen::VectorXd& v, double h, Eigen::VectorXd& force, BlockMatrix& A);

// Derivatives of the air's impulse with w held, by x through the normals and by v, shapes [3V, m].
// out += ∂g/∂x·dx + ∂g/∂v·dv.
void AddAirTangent(const ClothModel& model, const MaterialField& material, const MovingStep& step,
                   const RowMatrix& dx, const RowMatrix& dv, RowMatrix& out);
// adj_x += (∂g/∂x)ᵀ·λ, adj_v += (∂g/∂v)ᵀ·λ.
void AddAirAdjoint(const ClothModel& model, const MaterialField& material, const MovingStep& step,
                   const RowMatrix& lambda, RowMatrix& adj_x, RowMatrix& adj_v);

// The numbers by which DynamicsColumns derives, in this order.
enum DynamicsEntry : int {
  kByDensity,           // [kg/m²]
  kByMassDamping,       // α [1/s]
  kByStiffnessDamping,  // β [s]
  kByAirDrag,           // c [kg/m³]
  kByWind,              // x, y, z [m/s]
  kDynamicsEntries = kByWind + 3
};
// What each number adds to the right-hand side of A·dw, ∂(M·v + g − A·w)/∂(number) with x, v and w
// held, shape [3V, 7] [MODEL, M66].
RowMatrix DynamicsColumns(const ClothModel& model, const MaterialField& material,
                          const MovingStep& step);
// DynamicsColumnsᵀ·λ for one λ, shape [3V, 1]. stiffness_work: λ·H·w of the elements, as AdjStep
// returns it.
using DynamicsNumbers = Eigen::Vector<double, kDynamicsEntries>;
DynamicsNumbers DynamicsAdjoint(const ClothModel& model, const MaterialField& material,
                                const MovingStep& step, const RowMatrix& lambda,
                                double stiffness_work);

}  // namespace drape
