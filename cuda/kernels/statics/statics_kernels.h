// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.h"

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
void LaunchGatherStiffness(const LaunchContext& on, const DerivativeRecords& records,
                           const StiffnessTerms& terms, double* matrix);

// Force, stress and energy of the batch's shapes: sums[0] = ‖f‖² [N²], sums[1] = energy [J], by
// slot.
void LaunchMeasure(const LaunchContext& on, const StepRecords& records, const Shapes& shapes,
                   double* sums);

// to[slot] ← from[rollout of the slot], and back; [3V] each.
void LaunchGatherRows(const LaunchContext& on, const double* from, double* to);
void LaunchScatterRows(const LaunchContext& on, const double* from, double* to);

// move[slot] = largest |dx|; dx by slot.
void LaunchLargestMove(const LaunchContext& on, const double* dx, double* move);
// geometric ← the stress extrapolated along scale·dx, then x += scale·dx; scale by slot.
void LaunchMoveShapes(const LaunchContext& on, const double* dx, const double* scale,
                      StretchStress<double>* geometric, double* x);

// What is to be done after a step, by slot; geometric ← stress except for kGoOn.
enum class ShapeAction : int { kGoOn, kKeep, kRejectStep };
void LaunchShapeAction(const LaunchContext& on, const ShapeAction* action, const Shapes& here,
                       const Shapes& best, StretchStress<double>* geometric);

// dots[slot, j] = Σ a[·, j]·b[·, j]; shapes [3V, m] a slot.
void LaunchColumnDots(const LaunchContext& on, const double* a, const double* b, double* dots,
                      int columns);
// X ← X₋ + ω·(Z + X − X₋), X₋ ← X of CgwRecurrence; columns with ω < 0 stay. weight [slots, m].
void LaunchCgwAdvance(const LaunchContext& on, const double* weight, const double* step,
                      double* before, double* x, int columns);
// to = from, [count] numbers.
void LaunchCopy(const double* from, double* to, std::int64_t count, cudaStream_t stream);
// One round of Stiffness::Asymmetry: image += direction, radius = ‖image‖/‖direction‖, direction ←
// image/‖image‖; image ← 0. [3V] a slot.
void LaunchPowerStep(const LaunchContext& on, double* image, double* direction, double* radius);

}  // namespace drape
