// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/cloth/cloth_view.h"

namespace drape {

// Forces and step matrices of a batch: first a record per element, then sums by gather, so that no
// two threads write the same number and each run adds in the same order.

void LaunchElementRecords(const LaunchContext& on, const StepRecords& records);
// matrix = M + h²·H, [9·entries] a slot; rhs = M·v + h·f unless null, [3V] a slot; v by slot.
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

}  // namespace drape
