// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/kernels/cloth/cloth_view.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

// Newton's method for a batch of drapes (physics/simulation/statics/statics.h). Shapes and what
// belongs to them are kept by rollout, so that those that are done can leave the batch; systems by
// slot.
struct Shapes {
  double *x, *force;              // [3V]
  StretchStress<double>* stress;  // [F]
};

// Ks = ½(K + Kᵀ) of −∂f/∂x in `records`, + ∫(geometric − stress):∂²G/∂x², + μ·(M + ℓ²·L); lower
// triangle, [9·entries] a slot. geometric and stress, by rollout, may be null together.
struct StiffnessTerms {
  const StretchStress<double>*geometric, *stress;
  const double* mu;  // by slot [s⁻²]
  double length;     // ℓ [m]
};
void LaunchGatherStiffness(const ClothView& cloth, const ShapeBatch& batch,
                           const DerivativeRecords& records, const StiffnessTerms& terms,
                           double* matrix, cudaStream_t stream);

// Force, stress and energy of the batch's shapes: sums[0] = ‖f‖² [N²], sums[1] = energy [J], by
// slot.
void LaunchMeasure(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                   const FaceRecord* faces, const HingeRecord* hinges, const Shapes& shapes,
                   double* sums, cudaStream_t stream);

// to[slot] ← from[rollout of the slot], and back; [3V] each.
void LaunchGatherRows(int dofs, const int* rollout, const double* from, double* to, int slots,
                      cudaStream_t stream);
void LaunchScatterRows(int dofs, const int* rollout, const double* from, double* to, int slots,
                       cudaStream_t stream);

// move[slot] = largest |dx|; dx by slot.
void LaunchLargestMove(const ClothView& cloth, const double* dx, double* move, int slots,
                       cudaStream_t stream);
// geometric ← the stress extrapolated along scale·dx, then x += scale·dx; scale by slot.
void LaunchMoveShapes(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                      const double* dx, const double* scale, StretchStress<double>* geometric,
                      double* x, cudaStream_t stream);

// What is to be done after a step, by slot; geometric ← stress but for kGoOn.
enum class ShapeAction : int { kGoOn, kKeep, kRejectStep };
void LaunchShapeAction(const ClothView& cloth, const ShapeBatch& batch, const ShapeAction* action,
                       const Shapes& here, const Shapes& best, StretchStress<double>* geometric,
                       cudaStream_t stream);

// dots[slot, j] = Σ a[·, j]·b[·, j]; shapes [3V, m] a slot.
void LaunchColumnDots(int dofs, const double* a, const double* b, double* dots, int columns,
                      int slots, cudaStream_t stream);
// X ← X₋ + ω·(Z + X − X₋), X₋ ← X of CgwRecurrence; columns with ω < 0 stay. weight [slots, m].
void LaunchCgwAdvance(int dofs, const double* weight, const double* step, double* before, double* x,
                      int columns, int slots, cudaStream_t stream);
// to = from, [count] numbers.
void LaunchCopy(const double* from, double* to, std::int64_t count, cudaStream_t stream);
// One round of Stiffness::Asymmetry: image += direction, radius = ‖image‖/‖direction‖, direction ←
// image/‖image‖; image ← 0. [3V] a slot.
void LaunchPowerStep(int dofs, double* image, double* direction, double* radius, int slots,
                     cudaStream_t stream);

}  // namespace drape
