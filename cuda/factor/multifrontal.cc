// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/multifrontal.h"

#include <algorithm>

namespace drape {
namespace {

constexpr int kThreads = 256;
constexpr int kReservedShared = 1024;  // bytes of shared memory that the device adds to each block

int Bytes(int doubles) { return doubles * static_cast<int>(sizeof(double)); }

LevelRange MakeRange(const FrontPlan& plan, int level, std::vector<UpdateTile>* tiles) {
  LevelRange range{plan.level_start[level],
                   plan.level_start[level + 1],
                   0,
                   0,
                   0,
                   static_cast<int>(tiles->size()),
                   0};
  for (int i = range.begin; i < range.end; ++i) {
    const Front& front = plan.fronts[plan.level_front[i]];
    const int p = front.pivots, q = front.border;
    range.largest_pivots = std::max(range.largest_pivots, p);
    range.shared_panel = std::max(range.shared_panel, Bytes((p + q + 8) * (p + 4)));
    range.shared_solve = std::max(range.shared_solve, Bytes(p * (p + 1) + p + q + 2 * kThreads));
    const int rows = q > 0 ? (q + kUpdateTile) / kUpdateTile : 0;  // the right-hand side's included
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column <= row && column * kUpdateTile < q; ++column)
        tiles->push_back({plan.level_front[i], row, column});
  }
  range.tile_end = static_cast<int>(tiles->size());
  return range;
}

}  // namespace

Multifrontal::Multifrontal(const FrontPlan& plan, int shared_bytes)
    : fronts_(plan.fronts),
      children_(plan.children),
      entries_(plan.entries),
      border_dof_(plan.border_dof),
      level_front_(plan.level_front),
      source_(plan.source),
      child_row_(plan.child_row) {
  std::vector<UpdateTile> tiles;
  for (int level = 0; level < plan.num_levels(); ++level)
    levels_.push_back(MakeRange(plan, level, &tiles));
  tiles_ = DeviceBuffer<UpdateTile>(tiles);
  view_ = {fronts_.data(),      children_.data(),        entries_.data(),
           border_dof_.data(),  child_row_.data(),       source_.data(),
           level_front_.data(), 3 * plan.num_vertices(), static_cast<int>(plan.entries.size()),
           plan.factor_size,    plan.update_size,        plan.vector_size};
  int device = 0;
  CUDA_CHECK(cudaGetDevice(&device));
  CUDA_CHECK(cudaDeviceGetAttribute(&multiprocessors_, cudaDevAttrMultiProcessorCount, device));
  CUDA_CHECK(cudaDeviceGetAttribute(&shared_of_multiprocessor_,
                                    cudaDevAttrMaxSharedMemoryPerMultiprocessor, device));
  PrepareFactorKernels(shared_bytes);
  PrepareSolveKernels(shared_bytes);
  PrepareSolveManyKernels(shared_bytes);
}

bool Multifrontal::SplitsUpdates(int slots) const { return slots < multiprocessors_ / 4; }

int Multifrontal::FactorThreads(const LevelRange& level, int slots) const {
  if (slots < multiprocessors_ / 2) return kThreads;
  const int panels = shared_of_multiprocessor_ / (level.shared_panel + kReservedShared);
  return panels < 2 ? 2 * kThreads : panels == 2 ? kThreads : kThreads / 2;
}

void Multifrontal::FactorAndSolve(const FactorView& numbers, const double* rhs, double* solution,
                                  int slots, int all_slots, cudaStream_t stream) const {
  const UpdateTile* tiles = SplitsUpdates(all_slots) ? tiles_.data() : nullptr;
  for (const LevelRange& level : levels_)
    LaunchFactorLevel({view_, level, slots, stream}, numbers, tiles, rhs, solution,
                      FactorThreads(level, all_slots));
  if (rhs == nullptr) return;
  for (auto level = levels_.rbegin(); level != levels_.rend(); ++level)
    LaunchBackwardLevel({view_, *level, slots, stream}, numbers.factor, solution);
}

void Multifrontal::Solve(const FactorPlace& factor, const RightHandSides& sides, int slots,
                         cudaStream_t stream, const SolutionSum& sum) const {
  const auto& [rhs, solution, vectors, columns] = sides;
  for (const LevelRange& level : levels_) {
    const LevelLaunch on{view_, level, slots, stream};
    if (columns == 1) {
      LaunchForwardLevel(on, factor, rhs, solution, vectors);
    } else {
      LaunchForwardManyLevel(on, factor, rhs, solution, vectors, columns);
    }
  }
  for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
    const LevelLaunch on{view_, *level, slots, stream};
    if (columns == 1) {
      LaunchBackwardLevel(on, factor, solution);
    } else {
      LaunchBackwardManyLevel(on, factor, solution, sum, columns);
    }
  }
}

}  // namespace drape
