// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "cuda/device/device.h"
#include "cuda/factor/multifrontal_kernels.h"
#include "cuda/factor/plan/front_plan.h"
#include "physics/linalg/linear_solver.h"

namespace drape {

// Right-hand sides of a batch of systems, shape [dofs, columns] a slot, and where their solutions
// go; the two may be the same.
struct RightHandSides {
  const double* rhs;
  double* solution;
  double* vectors;  // workspace [vector_size, columns] a slot
  int columns;
};

// A plan on the present device: launches factorisations and solves of batches of systems.
class Multifrontal {
 public:
  // shared_bytes: of a block of threads on this device.
  Multifrontal(const FrontPlan& plan, int shared_bytes);

  const PlanView& view() const { return view_; }

  // A = L·Lᵀ for `slots` systems; rhs, when not null, is solved with along the way: solution =
  // A⁻¹·rhs, shapes [dofs] a slot. Pointers may be the same. `all_slots`: of all concurrent
  // streams, these included.
  void FactorAndSolve(const FactorView& numbers, const double* rhs, double* solution, int slots,
                      int all_slots, cudaStream_t stream) const;
  // solution = A⁻¹·rhs. `sum`: for columns > 1.
  void Solve(const FactorPlace& factor, const RightHandSides& sides, int slots, cudaStream_t stream,
             const SolutionSum& sum = {}) const;

 private:
  // Computes updates in blocks of their own where slots are too few to fill the device.
  bool SplitsUpdates(int slots) const;
  // Threads of a block that factors a front: the fewer panels fit on a multiprocessor at a time,
  // the more threads each has to hide its latency.
  int FactorThreads(const LevelRange& level, int slots) const;

  int multiprocessors_ = 0, shared_of_multiprocessor_ = 0;
  DeviceArrays arrays_;
  const UpdateTile* tiles_;
  std::vector<LevelRange> levels_;
  PlanView view_;
};

// A LinearSolver that factors one system at a time on a device, for a single large cloth, in the
// order of elimination that MakeLinearSolver has on the host. Copies may be used on threads of
// their own. Throws InputError where a front does not fit, CudaError, DeviceMemoryError.
std::unique_ptr<LinearSolver> MakeDeviceSolver(const BlockPattern& pattern,
                                               const DeviceInfo& device);

}  // namespace drape
