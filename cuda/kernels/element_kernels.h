// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/cloth/cloth_view.h"

namespace drape {

// Forces and step matrices of a batch: first a record per element, then sums by gather, so that no
// two threads write the same number and each run adds in the same order.

void LaunchElementRecords(const LaunchContext& on, const StepRecords& records);
// matrix = M + h²·H with the damping of the materials (assembly.h), [9·entries] a slot; rhs = M·v +
// h·f unless null, [3V] a slot; v by slot. Air acts unless v is null.
void LaunchGatherStep(const LaunchContext& on, const StepRecords& records, const double* v,
                      double h, double* matrix, double* rhs);
// force = f [N], [3V] by rollout.
void LaunchGatherForce(const LaunchContext& on, const StepRecords& records, double* force);

// The states of the rollouts, [3V] a slot.
struct StepState {
  double *x, *v;
  int* failed;  // [1] a slot: set where a number is not finite
};
// The states before each step and the velocity that it found, for the adjoint; x is null where they
// are not kept.
struct HistoryView {
  double *x, *v;        // [steps, slots, 3V]
  std::int64_t stride;  // numbers a step
  const int* step;      // the present step
};
// v ← solution, x += h·v.
void LaunchAdvance(const LaunchContext& on, const StepState& state, const double* solution,
                   double h, const HistoryView& history);
// *step += by.
void LaunchCountStep(int* step, int by, cudaStream_t stream);

// What obstacles do to the vertices of a batch, added to what the kernels of the cloth have written
// (physics/cloth/contact/vertex_contact.h). In a scene without obstacles nothing is launched.

// Moves vertices of x, by rollout, out of all obstacles.
void LaunchPushOut(const LaunchContext& on, double* x);

// matrix += h²·H, [9·entries] a slot; rhs += h·f unless null, [3V] a slot.
void LaunchAddContactStep(const LaunchContext& on, double h, double* matrix, double* rhs);
// force += f [N], [3V] by rollout.
void LaunchAddContactForce(const LaunchContext& on, double* force);
// sums[1] += energy [J], two numbers a slot.
void LaunchAddContactEnergy(const LaunchContext& on, double* sums);
// matrix −= ∂f/∂x, [9·entries] a slot.
void LaunchAddContactStiffness(const LaunchContext& on, double* matrix);
// blocks += ∂g/∂x, [9·num_blocks] a slot; w: by slot, [3V].
void LaunchAddContactDerivative(const LaunchContext& on, const double* w, double h, double* blocks);
// adj_x += (∂g/∂x)ᵀ·lambda, [3V] a slot.
void LaunchAddContactAdjoint(const LaunchContext& on, const double* w, double h,
                             const double* lambda, double* adj_x);

// Shortens the moves scale·direction of vertices that would enter an obstacle by shortening their
// direction, [3V] a slot. by_slot: the scale of each slot, or null where it is `scale`. blocked[s]
// is set to 1 where a move of slot s was shortened, unless null.
struct MoveScale {
  const double* by_slot;
  double scale;
};
void LaunchShortenMoves(const LaunchContext& on, MoveScale scale, double* direction, int* blocked);

}  // namespace drape
