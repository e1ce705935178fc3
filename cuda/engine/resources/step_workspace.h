// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "cuda/device/arena.h"
#include "cuda/kernels/cloth/device_cloth.h"
#include "cuda/kernels/element_kernels.h"

namespace drape {

// Workspace of a step by slot.
struct StepWorkspace {
  double *x, *v;  // [3V]
  double *matrix, *update;
  FactorPlace factor;
  double *rhs, *solution;  // [3V]
  StepRecords records;
  int* failed;  // [1]
  int* step;    // [1] of all slots

  static StepWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots);

  // The records of the slots from `first` on.
  StepRecords RecordsFrom(const ClothView& cloth, std::int64_t first) const {
    return {records.faces + first * cloth.num_faces, records.hinges + first * cloth.num_hinges};
  }
  double* MatrixFrom(const PlanView& plan, std::int64_t first) const {
    return matrix + first * 9 * plan.num_entries;
  }
  FactorView FactorFrom(const PlanView& plan, std::int64_t first) const {
    return {MatrixFrom(plan, first), factor.From(first, plan.factor_size),
            update + first * plan.update_size, failed + first};
  }
};

// Launches of a group of slots, from `first` on; on.batch is the group.
// Records, matrix and right-hand side, then v' in workspace.solution.
void LaunchSolveStep(const LaunchContext& on, const Multifrontal& multifrontal,
                     const StepWorkspace& workspace, int first, double h);
// Factors A at the group's shapes and solves for rhs in place, unless it is null.
void LaunchFactorStep(const LaunchContext& on, const Multifrontal& multifrontal,
                      const StepWorkspace& workspace, int first, double h, double* rhs);
// What a move is that an obstacle shortens: the end of that move, or a failure of its slot.
enum class BlockedMove { kEnds, kFails };
// v ← v', x ← x + h·v', as far as obstacles let it; history: of all slots.
void LaunchAdvanceGroup(const LaunchContext& on, const StepWorkspace& workspace, int first,
                        double h, BlockedMove blocked, const HistoryView& history);

}  // namespace drape
