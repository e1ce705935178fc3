// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "cuda/device/device.h"
#include "cuda/kernels/cloth/cloth_view.h"
#include "cuda/kernels/cloth/device_cloth.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.h"
#include "physics/simulation/backend.h"

namespace drape {

// What the engines of one device share: the cloth and its factorisation plan, streams, and the
// memory of the present batch's workspace. One thread at a time uses it.
class DeviceResources {
 public:
  // threads: of the host, for what comes back from the device.
  DeviceResources(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                  const DeviceInfo& device, int threads);

  const DeviceInfo& device() const { return device_; }
  int threads() const { return threads_; }
  const DeviceCloth& cloth() const { return *cloth_; }
  const ClothView& view() const { return cloth_->view(); }
  const Streams& streams() const { return *streams_; }
  cudaStream_t stream() const { return streams_->main(); }
  LaunchContext On(const ShapeBatch& batch) const { return On(batch, stream()); }
  LaunchContext On(const ShapeBatch& batch, cudaStream_t stream) const {
    return {view(), batch, cloth_->law(), stream};
  }

  // Memory of this device that a batch may use [bytes]: what is free and the workspace of the batch
  // before. Makes it the calling thread's present device, like ForEachChunk.
  std::size_t FreeBytes() const;
  using TakeWorkspace = std::function<void(Arena&, int slots)>;
  // Makes this device the calling thread's present one, then calls work(first, count) for chunks of
  // a batch of `count` whose workspace fits in addition to `reserve` bytes a slot. Throws
  // DeviceMemoryError when not even one slot does.
  using ChunkWork = std::function<void(std::size_t first, std::size_t count)>;
  void ForEachChunk(std::size_t count, const TakeWorkspace& take, std::size_t reserve,
                    const ChunkWork& work) const;
  // Calls take(arena, slots) with memory for it, which the next batch uses again.
  void Allocate(int slots, const TakeWorkspace& take);

  // Starts of a batch to x and v [dofs] a slot, unless v is null; the ends of a batch back from
  // there. Both wait for the main stream.
  void UploadStarts(std::span<const RolloutInput> batch, double* x, double* v);
  void DownloadEnds(const double* x, const double* v, std::span<RolloutResult* const> results);
  void Clear(void* data, std::size_t bytes) const;
  // Replays `graph` for each step; the steps that were done before `cancel` turned true.
  int RunSteps(const Graph& graph, int steps, const std::atomic<bool>* cancel) const;

 private:
  void Bind() const;
  int SlotsThatFit(int wanted, const TakeWorkspace& take, std::size_t reserve) const;

  DeviceInfo device_;
  int threads_;
  std::unique_ptr<DeviceCloth> cloth_;
  std::unique_ptr<Streams> streams_;
  DeviceBuffer<char> memory_;
  PinnedBuffer<double> staging_;
};

std::vector<const MaterialField*> CollectMaterials(std::span<const RolloutInput> batch);

// The slots [first, first + slots) of a batch whose slots are its rollouts.
ShapeBatch SliceBatch(const ShapeBatch& batch, int first, int slots, int num_dofs);

// Number of columns that the kernels work on: one or an even number.
inline int PaddedColumns(int m) { return m == 1 ? 1 : (m + 1) / 2 * 2; }

// What a gradient needs at most for m columns [bytes of a slot].
inline std::size_t GradientBytes(const ClothView& cloth, int columns) {
  return sizeof(double) * columns *
         (kStretchEntries * std::size_t{1} * cloth.num_faces + kBendEntries * cloth.num_hinges);
}

// Gradients by the tables of a batch's materials, sums over elements in rows as GradientRows says;
// zero at first.
class DeviceGradient {
 public:
  DeviceGradient(std::span<const RolloutInput> batch, int faces, int hinges, int columns);

  // The gradients of the slots from `first` on.
  GradientView From(int first);
  // The first m columns of slot i, its chunks added up in order. Waits for no stream.
  MaterialGradient Collect(const RolloutInput& input, int i, int m);

 private:
  int columns_;
  std::vector<std::int64_t> stretch_start_, bend_start_;
  DeviceBuffer<double> stretch_, bend_;
  DeviceBuffer<std::int64_t> stretch_starts_, bend_starts_;
  std::vector<double> host_stretch_, host_bend_;  // after the first Collect
};

// Workspace of a step by slot.
struct StepWorkspace {
  double *x, *v;  // [3V]
  double *matrix, *update;
  FactorPlace factor;
  double *rhs, *solution;  // [3V]
  double* damped;          // [3V], of derivatives; null where no material of the batch needs it
  StepRecords records;
  int* failed;  // [1]
  int* step;    // [1] of all slots

  static StepWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots);

  // The numbers of the slots from `first` on.
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
// Factors A at the group's shapes and solves for rhs in place, unless it is null. v: velocities of
// the group before the step, null where no air acts.
void LaunchFactorStep(const LaunchContext& on, const Multifrontal& multifrontal,
                      const StepWorkspace& workspace, const double* v, int first, double h,
                      double* rhs);
// What a move is that an obstacle shortens: the end of that move, or a failure of its slot.
enum class BlockedMove { kEnds, kFails };
// v ← v', x ← x + h·v', as far as obstacles let it; history: of all slots.
void LaunchAdvanceGroup(const LaunchContext& on, const StepWorkspace& workspace, int first,
                        double h, BlockedMove blocked, const HistoryView& history);

}  // namespace drape
