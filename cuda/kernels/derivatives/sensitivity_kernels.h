// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/cloth/cloth_view.h"
#include "physics/material/laws/bend_element.h"

namespace drape {

// Derivatives of the step force g(x; w) = h·f(x) − h²·H(x)·w of a batch
// (physics/cloth/assembly/assembly.h) by position and by material. w: by slot, [3V].

// The derivative of an element by position.
struct FaceDerivative {
  double Q[6][6];  // ∂g/∂F by rest area
};
struct HingeDerivative {
  double block[4][4][9];  // of its corners
};
// The derivative of an element by its table: ∂g/∂entry = factor[entry]·basis[column of the entry].
struct FaceFactors {
  DeformationGradient<double> basis[kStretchCols];  // area included
  double factor[kStretchEntries];
};
struct HingeFactors {
  HingeGradient basis;
  double factor[kBendEntries];
};

using DerivativeRecords = BatchRecords<FaceDerivative, HingeDerivative>;
using FactorRecords = BatchRecords<FaceFactors, HingeFactors>;

// damped = (1 + β/h)·w of each slot, [3V]: the w of the records where elements are damped by their
// stiffness (DampedVelocity). Contact takes w itself.
void LaunchDampVelocity(const LaunchContext& on, const double* w, double h, double* damped);
void LaunchDerivativeRecords(const LaunchContext& on, const double* w, double h,
                             const DerivativeRecords& records);
// blocks = ∂g/∂x, [9·num_blocks] a slot; w: of the contact.
void LaunchGatherDerivative(const LaunchContext& on, const DerivativeRecords& records,
                            const double* w, double h, double* blocks);
// weight: of each entry, by rollout (its density and damping are unused).
void LaunchFactorRecords(const LaunchContext& on, const MaterialView* weight, const double* w,
                         double h, const FactorRecords& records);

// Right-hand sides of a step's tangents: dv ← M·dv + ∂g/∂x·dx + ∂g/∂p; shapes [3V, columns] a slot,
// an even number of columns: the entries, the padding to kPaddedEntries, which is zero, and further
// ones, for which ∂g/∂p is zero. dx may be null: dv ← ∂g/∂p.
void LaunchTangentRhs(const LaunchContext& on, const FactorRecords& records, const double* blocks,
                      const double* dx, double* dv, int columns);

// One column, the change of every entry by the weight that `records` were made with: rhs ← the sum
// of the columns ∂g/∂p, [3V] a slot.
void LaunchDirectionRhs(const LaunchContext& on, const FactorRecords& records, double* rhs);

// Where the states of a slot lie, step by step.
struct HistorySlot {
  const double *x, *v;  // [3V] at x + step·stride
  std::int64_t stride;
};
// x, v ← the states of step *step, [dofs] a slot.
void LaunchLoadHistory(const LaunchContext& on, const HistorySlot* history, const int* step,
                       double* x, double* v);

// The adjoint of a step, for m columns; shapes [3V, m] a slot.
// adj += seeds.
void LaunchAddSeeds(const LaunchContext& on, const double* seeds, double* adj, int columns);
// rhs = adj_v + h·adj_x.
void LaunchAdjointRhs(const LaunchContext& on, const double* adj_x, const double* adj_v, double h,
                      double* rhs, int columns);
// adj_x += (∂g/∂x)ᵀ·lambda, adj_v = M·lambda.
void LaunchAdjointPosition(const LaunchContext& on, const double* blocks, const double* lambda,
                           double* adj_x, double* adj_v, int columns);

// Sums over elements are kept by chunks of them, to be added up in order at the end: a row of 24 or
// 15 entries for each element of a field, or for each chunk where one table serves all.
inline constexpr int kGradientChunk = kElementThreads;
inline int GradientRows(int elements, int stride) {
  return stride != 0 ? elements : (elements + kGradientChunk - 1) / kGradientChunk;
}
struct GradientView {
  double* stretch;  // [24·GradientRows(F), m] a slot, by slot at stretch_start
  double* bend;     // [15·GradientRows(E), m]
  const std::int64_t *stretch_start, *bend_start;  // [slots]
};
// The whole adjoint of a step for a single column, element by element, without the blocks of ∂g/∂x.
// The record of a face is ∂(g·λ)/∂F by rest area.
using AdjointRecords = BatchRecords<DeformationGradient<double>, BendAdjoint>;
// records, and gradient += (∂g/∂entry)ᵀ·lambda.
void LaunchAdjointRecords(const LaunchContext& on, const double* w, double h, const double* lambda,
                          const AdjointRecords& records, const GradientView& gradient);
// adj_x += (∂g/∂x)ᵀ·lambda, adj_v = M·lambda; [3V] a slot; w: of the contact.
void LaunchGatherAdjoint(const LaunchContext& on, const AdjointRecords& records, const double* w,
                         double h, const double* lambda, double* adj_x, double* adj_v);

// gradient += (∂g/∂entry)ᵀ·lambda.
void LaunchAdjointMaterial(const LaunchContext& on, const double* w, double h, const double* lambda,
                           const GradientView& gradient, int columns);

// A step of a batch of moving cloths: the velocities before and after it, [3V] a slot each.
struct MovingStepView {
  const double *v, *w;
  double h;
};
// The numbers of DynamicsEntry (physics/cloth/assembly/dynamics.h), of slots in air or not.
inline constexpr int kDynamicsNumbers = 7;
// Where their columns go: `count` of them, from column `first` on of [3V, columns] a slot.
struct DynamicsPlace {
  double* matrix;
  int columns = kDynamicsNumbers, first = 0, count = kDynamicsNumbers;
  bool adds = false;  // to what is there
};
// ∂(M·v + g − A·w)/∂(number).
void LaunchDynamicsColumns(const LaunchContext& on, const MovingStepView& step,
                           const DynamicsPlace& place);
// gradient += numbersᵀ·lambda, [7, columns] a slot; numbers: [3V, 7].
void LaunchDynamicsGradient(const LaunchContext& on, const double* numbers, const double* lambda,
                            double* gradient, int columns);
// Derivatives of the air's impulse with w held (AddAirTangent, AddAirAdjoint), by slots with a
// drag; shapes [3V, columns] a slot. dv += M⁻¹·(∂g/∂x·dx + ∂g/∂v·dv).
void LaunchAddAirTangent(const LaunchContext& on, const MovingStepView& step, const double* dx,
                         double* dv, int columns);
// adj_x += (∂g/∂x)ᵀ·lambda, adj_v += (∂g/∂v)ᵀ·lambda.
void LaunchAddAirAdjoint(const LaunchContext& on, const MovingStepView& step, const double* lambda,
                         double* adj_x, double* adj_v, int columns);
// v ← the velocities before step *step: start_v, [3V] a slot, before the first.
void LaunchLoadBefore(const LaunchContext& on, const HistorySlot* history, const double* start_v,
                      const int* step, double* v);

// y += blocks·x or blocksᵀ·x, shapes [3V, m] a slot.
void LaunchMultiply(const LaunchContext& on, const double* blocks, bool transposed, const double* x,
                    double* y, int columns);

}  // namespace drape
