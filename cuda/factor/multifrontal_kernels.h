// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <cstdint>

#include "cuda/factor/plan/front_plan.h"

namespace drape {

// A FrontPlan in device memory.
struct PlanView {
  const Front* fronts;
  const FrontChild* children;
  const FrontEntry* entries;
  const int* border_dof;
  const std::int16_t* child_row;
  const int* source;
  const int* level_front;
  int num_dofs, num_entries;
  std::int64_t factor_size, update_size;
  int vector_size;
};

// Where the factors of a batch lie, [factor_size] a slot; factors of steps are `stride` apart.
struct FactorPlace {
  double* base;
  const int* step = nullptr;  // the present one; null where there is one step only
  std::int64_t stride = 0;

  FactorPlace From(std::int64_t first, std::int64_t factor_size) const {
    return {base + first * factor_size, step, stride};
  }
#ifdef __CUDACC__
  __device__ double* Of(const PlanView& plan, std::int64_t slot) const {
    return base + (step == nullptr ? 0 : *step * stride) + slot * plan.factor_size;
  }
#endif
};

// Numbers of a batch of systems on one plan; slot s has its own at s × the size given.
struct FactorView {
  const double* matrix;  // [9·entries] blocks of the lower triangle, row-major
  FactorPlace factor;
  double* update;  // [update_size]
  int* failed;     // [1] set where a pivot is not positive
};

// One level of the elimination tree: fronts plan.level_front[begin, end).
struct LevelRange {
  int begin, end;
  int largest_pivots;
  int shared_panel;          // bytes of the largest panel [p + q + 8, p + 4]
  int shared_solve;          // bytes of the largest solve with one right-hand side
  int tile_begin, tile_end;  // of the 64 × 64 tiles of the level's updates
};

// A level of the elimination tree of `slots` systems.
struct LevelLaunch {
  const PlanView& plan;
  const LevelRange& level;
  int slots;
  cudaStream_t stream;
};

// A tile of a front's update matrix.
struct UpdateTile {
  int front, row, column;  // in tiles of 64
};

inline constexpr int kUpdateTile = 64;

// Raise the kernels' limits of shared memory on the present device [bytes of a block]. Once before
// any launch.
void PrepareFactorKernels(int shared_bytes);
void PrepareSolveKernels(int shared_bytes);
void PrepareSolveManyKernels(int shared_bytes);

// Factors a level; forward-substitutes right-hand side rhs [dofs] into solution
// [dofs] on the way, unless rhs is null. `tiles`: null, or the updates are computed by blocks of
// their own (few systems: more parallelism).
void LaunchFactorLevel(const LevelLaunch& on, const FactorView& view, const UpdateTile* tiles,
                       const double* rhs, double* solution, int threads);
// Solves with stored factors, one right-hand side: forward up the tree, backward down it.
// vectors: workspace [vector_size].
void LaunchForwardLevel(const LevelLaunch& on, const FactorPlace& factor, const double* rhs,
                        double* solution, double* vectors);
void LaunchBackwardLevel(const LevelLaunch& on, const FactorPlace& factor, double* solution);
// Solve for `columns` right-hand sides, shape [dofs, columns] a slot; vectors [vector_size,
// columns].
void LaunchForwardManyLevel(const LevelLaunch& on, const FactorPlace& factor, const double* rhs,
                            double* solution, double* vectors, int columns);
// What is found is added up on the way: sum += scale·solution, unless sum is null.
struct SolutionSum {
  double* sum = nullptr;  // [dofs, columns] a slot
  double scale = 0.0;
};
void LaunchBackwardManyLevel(const LevelLaunch& on, const FactorPlace& factor, double* solution,
                             const SolutionSum& sum, int columns);

}  // namespace drape
