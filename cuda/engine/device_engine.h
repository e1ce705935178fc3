// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "cuda/device/arena.h"
#include "cuda/device/device.h"
#include "cuda/kernels/cloth/device_cloth.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.h"
#include "physics/simulation/backend.h"

namespace drape {

// States of a batch of rollouts on a device, [steps, slots, 3V] in elimination order, and the
// factors of all steps where there was room for them.
struct DeviceHistory {
  int device, slots;
  DeviceBuffer<double> x, v;
  DeviceBuffer<double> factor;  // [steps, slots, factor_size], or empty
};
// One rollout of it.
struct DeviceRecording final : BackendRecording {
  std::shared_ptr<const DeviceHistory> history;
  int slot = 0, steps = 0;
};

// Those of all its slots, after `steps` steps.
std::vector<Recording> MakeRecordings(const std::shared_ptr<const DeviceHistory>& history,
                                      int steps);

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
  StepRecords RecordsFrom(const ClothView& cloth, std::int64_t first) const {
    return {records.faces + first * cloth.num_faces, records.hinges + first * cloth.num_hinges};
  }
};

// Batches on one device. Results that the device could not find (a pivot that is not positive, a
// number that is not finite) are marked in `failed`, for the host to decide.
class DeviceEngine {
 public:
  // threads: of the host, for what comes back from the device.
  DeviceEngine(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
               const DeviceInfo& device, int threads);

  const DeviceInfo& device() const { return device_; }

  // recordings: empty, or one a rollout.
  void Rollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                std::span<Recording> recordings, std::span<RolloutResult> results,
                std::span<char> failed);
  void Tangents(std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
                const RolloutOptions& options, std::span<TangentResult> results,
                std::span<char> failed);
  void ReadoutTangents(std::span<const RolloutInput> batch,
                       std::span<const MaterialField* const> weights, const RolloutOptions& options,
                       const Readout& readout, std::span<ReadoutTangent> results,
                       std::span<char> failed);
  // All recordings have the same number of steps, all seeds the same number of columns.
  void Adjoints(std::span<const RolloutInput> batch, std::span<const Recording* const> recordings,
                std::span<const RowMatrix* const> seeds, const RolloutOptions& options,
                std::span<AdjointResult> results, std::span<char> failed);
  // For readouts that a device knows, all of one kind.
  void LossGradients(std::span<const RolloutInput> batch, const RolloutOptions& options,
                     const ReadoutLoss& loss, std::span<LossGradient> results,
                     std::span<char> failed);

  // All of a batch are treated together; a drape that is at rest leaves it.
  void Equilibria(std::span<const RolloutInput> batch, const EquilibriumOptions& options,
                  std::span<EquilibriumResult> results);
  // As in Backend.
  void EquilibriumTangents(std::span<const RolloutInput> batch,
                           std::span<const MaterialField* const> weights,
                           std::span<RowMatrix> results);
  void EquilibriumReadoutTangents(std::span<const RolloutInput> batch,
                                  std::span<const MaterialField* const> weights,
                                  const Readout& readout, std::span<LinearReadout> results);
  // All seeds have the same number of columns.
  void EquilibriumAdjoints(std::span<const RolloutInput> batch,
                           std::span<const RowMatrix* const> seeds,
                           std::span<std::optional<MaterialGradient>> results);

 private:
  struct TangentWorkspace;
  struct AdjointWorkspace;
  struct ImplicitWorkspace;
  friend class BatchNewton;

  // Where the states of a recorded batch go, and whether its factors are kept too.
  struct HistoryChoice {
    bool on_device = false, with_factors = false;
  };
  HistoryChoice ChooseHistory(std::size_t rollouts, int steps) const;
  std::size_t FactorBytes(int steps) const;  // of one rollout
  struct RolloutRun {
    StepWorkspace workspace;                 // x, v: the ends
    std::shared_ptr<DeviceHistory> history;  // empty but with a record
    int done;                                // steps
  };
  RolloutRun RunRollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                         HistoryChoice choice, bool record);
  void RolloutChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                    HistoryChoice choice, std::span<Recording> recordings,
                    std::span<RolloutResult> results, std::span<char> failed);
  using ChunkWork = std::function<void(std::size_t first, std::size_t count)>;
  void ForEachTangentChunk(std::size_t count, const ChunkWork& work);
  TangentWorkspace TangentChunk(std::span<const RolloutInput> batch,
                                std::span<const MaterialField* const> weights,
                                const RolloutOptions& options, std::span<RolloutResult* const> ends,
                                std::span<char> failed);
  void LaunchTangentStep(const TangentWorkspace& workspace, const ShapeBatch& group,
                         const MaterialView* scales, std::int64_t first, double h,
                         cudaStream_t stream) const;
  void DownloadTangents(const double* from, std::span<TangentResult> results,
                        RowMatrix TangentResult::*part) const;
  // Shapes with their derivatives on the device, and the shapes on the host; null: not read.
  struct TangentShapes {
    const double *x, *dx;  // [3V], [3V, kPaddedEntries] a slot
    std::span<const Eigen::VectorXd* const> host;
  };
  void ReadTangents(const TangentShapes& shapes, const Readout& readout,
                    std::span<LinearReadout* const> results) const;
  void ReadOutlineTangents(const TangentShapes& shapes, const Readout& readout,
                           std::span<LinearReadout* const> results) const;
  void ReadTangentsOnHost(const TangentShapes& shapes, const Readout& readout,
                          std::span<LinearReadout* const> results) const;
  // rows·dx, [slots, rows, kPaddedEntries].
  std::vector<double> MultiplyRows(const SparseRows& sparse, int rows, const double* dx,
                                   int slots) const;

  // Writes ∂L/∂x of the ends, [3V, columns] a slot.
  using WriteSeeds = std::function<void(double* adj_x)>;
  struct AdjointRun;
  AdjointRun RunAdjoint(std::span<const RolloutInput> batch,
                        std::span<const Recording* const> recordings, int columns,
                        const WriteSeeds& write_seeds, const RolloutOptions& options);
  struct AdjointStep;
  void LaunchAdjointStep(const AdjointStep& step, int first, int count, cudaStream_t stream) const;
  std::size_t LossBytes(const DeviceReadout& readout) const;  // of one slot's loss and gradient
  // `first`: of the batch that `loss` knows.
  void LossChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                 HistoryChoice choice, const ReadoutLoss& loss, std::size_t first,
                 std::span<LossGradient> results, std::span<char> failed);
  void AdjointChunk(std::span<const RolloutInput> batch,
                    std::span<const Recording* const> recordings,
                    std::span<const RowMatrix* const> seeds, const RolloutOptions& options,
                    std::span<AdjointResult> results, std::span<char> failed);

  // Calls work(first, count) for chunks of a batch that fit.
  void ForEachImplicitChunk(std::size_t count, const ChunkWork& work);
  struct ImplicitRun;
  ImplicitRun RunImplicitTangents(std::span<const RolloutInput> batch,
                                  std::span<const MaterialField* const> weights);
  void EquilibriumAdjointChunk(std::span<const RolloutInput> batch,
                               std::span<const RowMatrix* const> seeds,
                               std::span<std::optional<MaterialGradient>> results);
  // Factors Ks of the batch's shapes, without shift; workspace.step.failed says where it could not.
  void FactorStiffness(const ImplicitWorkspace& workspace, const ShapeBatch& batch) const;
  // Solves K·X = B or Kᵀ·X = B for workspace.rhs; true where each column is solved.
  std::vector<char> SolveStiffness(const ImplicitWorkspace& workspace, const ShapeBatch& batch,
                                   bool transposed, int columns) const;

  // Makes this device the calling thread's present one.
  void Bind() const;
  // The most slots of at most `wanted` whose workspace fits beside `reserve` bytes a slot. Throws
  // DeviceMemoryError when not even one does.
  using TakeWorkspace = std::function<void(Arena&, int slots)>;
  int SlotsThatFit(int wanted, const TakeWorkspace& take, std::size_t reserve = 0) const;
  // Memory for a workspace, kept for the next one.
  Arena MakeRoom(int slots, const TakeWorkspace& take);

  void UploadStarts(std::span<const RolloutInput> batch, double* x, double* v) const;
  void Clear(void* data, std::size_t bytes) const;
  // Records, matrix and right-hand side, then v' in workspace.solution, of a group of slots.
  void LaunchSolveStep(const StepWorkspace& workspace, const ShapeBatch& group, int first, double h,
                       cudaStream_t stream) const;
  // Factors A at the group's shapes and solves for rhs in place, unless it is null.
  void LaunchFactorStep(const StepWorkspace& workspace, const ShapeBatch& group, int first,
                        double h, double* rhs, cudaStream_t stream) const;
  double* MatrixFrom(const StepWorkspace& workspace, std::int64_t first) const;
  FactorView FactorFrom(const StepWorkspace& workspace, std::int64_t first) const;
  void LaunchAdvanceGroup(const StepWorkspace& workspace, const HistoryView& history, int first,
                          int slots, double h, cudaStream_t stream) const;
  // Replays `graph` for each step; the steps that were done before `cancel` turned true.
  int RunSteps(const Graph& graph, int steps, const std::atomic<bool>* cancel) const;
  void CollectEnds(const StepWorkspace& workspace, int steps, int wanted_steps,
                   std::span<RolloutResult* const> results, std::span<char> failed) const;

  DeviceInfo device_;
  int threads_;
  std::unique_ptr<DeviceCloth> cloth_;
  std::unique_ptr<Streams> streams_;
  DeviceBuffer<char> memory_;
};

// The slots [first, first + slots) of a batch whose slots are its rollouts.
ShapeBatch SliceBatch(const ShapeBatch& batch, int first, int slots, int num_dofs);

}  // namespace drape
