// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/kernels/cloth/cloth_view.h"

namespace drape {

// Forces and step matrices of a batch: first a record an element, then sums by gather, so that no
// two threads write the same number and each run adds in the same order.

// Workspace of a batch by slot.
struct StepRecords {
  FaceRecord* faces;    // [F]
  HingeRecord* hinges;  // [E]
};

// `law`: on this device, see DeviceLaw.
void LaunchElementRecords(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                          const StepRecords& records, cudaStream_t stream);
// matrix = M + h²·H, [9·entries] a slot; rhs = M·v + h·f unless null, [3V] a slot; v by slot.
void LaunchGatherStep(const ClothView& cloth, const ShapeBatch& batch, const StepRecords& records,
                      const double* v, double h, double* matrix, double* rhs, cudaStream_t stream);
// force = f [N], [3V] by rollout.
void LaunchGatherForce(const ClothView& cloth, const ShapeBatch& batch, const StepRecords& records,
                       double* force, cudaStream_t stream);

// Where the rollouts stand, [3V] a slot.
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
void LaunchAdvance(const ClothView& cloth, const StepState& state, const double* solution, double h,
                   const HistoryView& history, int slots, cudaStream_t stream);
// *step += by.
void LaunchCountStep(int* step, int by, cudaStream_t stream);

}  // namespace drape
