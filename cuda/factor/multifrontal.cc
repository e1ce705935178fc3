// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/multifrontal.h"

#include <glog/logging.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "cuda/factor/plan/front_plan.h"
#include "physics/linalg/symbolic_analysis.h"

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

// What copies of a solver share.
struct Analysis {
  Analysis(const BlockPattern& pattern_in, EliminationOrder order_in, const DeviceInfo& device_in)
      : pattern(pattern_in),
        order(std::move(order_in)),
        device(device_in),
        plan(MakeFrontPlan(pattern, MakeSeparators(pattern, order.vertex),
                           {.shared_bytes = device.shared_bytes})),
        multifrontal(plan, device.shared_bytes) {
    for (const FrontEntry& entry : plan.entries)
      source.push_back(pattern.Find(plan.vertex[entry.row], plan.vertex[entry.column]));
  }

  BlockPattern pattern;
  EliminationOrder order;
  DeviceInfo device;
  FrontPlan plan;
  Multifrontal multifrontal;
  std::vector<int> source;  // of each entry of the plan: its block in the matrix
};

class DeviceSolver final : public LinearSolver {
 public:
  explicit DeviceSolver(std::shared_ptr<const Analysis> analysis)
      : analysis_(std::move(analysis)) {}

  std::unique_ptr<LinearSolver> Clone() const override {
    auto clone = std::make_unique<DeviceSolver>(analysis_);
    clone->threads_ = threads_;
    return clone;
  }

  std::unique_ptr<LinearSolver> Adapt(const BlockPattern& other) const override {
    MakePresent();
    auto adapted = std::make_unique<DeviceSolver>(std::make_shared<Analysis>(
        other, AdaptOrder(analysis_->order, analysis_->pattern, other), analysis_->device));
    adapted->threads_ = threads_;
    return adapted;
  }

  bool Factor(const BlockMatrix& A) override {
    if (cancelled()) return false;
    MakePresent();
    Allocate();
    const std::span<double> staged = staged_.Take(9 * analysis_->source.size());
#pragma omp parallel for num_threads(threads_) if (threads_ > 1)
    for (std::size_t k = 0; k < analysis_->source.size(); ++k)
      std::copy_n(A.block(analysis_->source[k]), 9, &staged[9 * k]);
    const cudaStream_t stream = streams_->main();
    CUDA_CHECK(cudaMemcpyAsync(matrix_.data(), staged.data(), staged.size_bytes(),
                               cudaMemcpyHostToDevice, stream));
    CUDA_CHECK(cudaMemsetAsync(failed_.data(), 0, failed_.bytes(), stream));
    analysis_->multifrontal.FactorAndSolve(
        {matrix_.data(), {factor_.data()}, update_.data(), failed_.data()}, nullptr, nullptr, 1, 1,
        stream);
    int failed = 0;
    CUDA_CHECK(
        cudaMemcpyAsync(&failed, failed_.data(), sizeof failed, cudaMemcpyDeviceToHost, stream));
    streams_->Synchronize();
    return failed == 0;
  }

  void Solve(Eigen::VectorXd& b) override { SolveWith(factor_, b); }
  void Solve(RowMatrix& b) override { SolveColumns(factor_, b); }
  void SaveFactor(std::vector<double>& saved) const override {
    MakePresent();
    saved.resize(factor_.size());
    CopyToHost(factor_.data(), std::span(saved));
  }
  void SolveSaved(const std::vector<double>& saved, RowMatrix& b) override {
    CHECK_EQ(saved.size(), static_cast<std::size_t>(analysis_->plan.factor_size));
    MakePresent();
    Allocate();
    DeviceBuffer<double> factor(saved);
    SolveColumns(factor, b);
  }
  std::size_t factor_bytes() const override { return analysis_->plan.factor_size * sizeof(double); }
  double factor_flops() const override { return analysis_->plan.flops; }
  void SetThreads(int threads) override { threads_ = threads; }

 private:
  void MakePresent() const { CUDA_CHECK(cudaSetDevice(analysis_->device.index)); }

  void Allocate() {
    if (streams_ != nullptr) return;
    const FrontPlan& plan = analysis_->plan;
    matrix_.Reserve(9 * plan.entries.size());
    factor_.Reserve(plan.factor_size);
    update_.Reserve(plan.update_size);
    vector_.Reserve(3 * plan.vertex.size());
    borders_.Reserve(plan.vector_size);
    failed_.Reserve(1);
    streams_ = std::make_unique<Streams>();
  }

  void SolveWith(DeviceBuffer<double>& factor, Eigen::VectorXd& b) {
    CHECK(streams_ != nullptr) << "no factor";
    MakePresent();
    const std::vector<int>& position = analysis_->plan.position;
    const std::span<double> staged = staged_.Take(b.size());
    for (std::size_t i = 0; i < position.size(); ++i)
      std::copy_n(&b[3 * i], 3, &staged[3 * position[i]]);
    const cudaStream_t stream = streams_->main();
    CUDA_CHECK(cudaMemcpyAsync(vector_.data(), staged.data(), staged.size_bytes(),
                               cudaMemcpyHostToDevice, stream));
    analysis_->multifrontal.Solve({factor.data()},
                                  {vector_.data(), vector_.data(), borders_.data(), 1}, 1, stream);
    CUDA_CHECK(cudaMemcpyAsync(staged.data(), vector_.data(), staged.size_bytes(),
                               cudaMemcpyDeviceToHost, stream));
    streams_->Synchronize();
    for (std::size_t i = 0; i < position.size(); ++i)
      std::copy_n(&staged[3 * position[i]], 3, &b[3 * i]);
  }

  void SolveColumns(DeviceBuffer<double>& factor, RowMatrix& b) {
    for (Eigen::Index c = 0; c < b.cols(); ++c) {
      Eigen::VectorXd column = b.col(c);
      SolveWith(factor, column);
      b.col(c) = column;
    }
  }

  std::shared_ptr<const Analysis> analysis_;
  int threads_ = 1;
  // Made by the first factorisation.
  std::unique_ptr<Streams> streams_;
  PinnedBuffer<double> staged_;
  DeviceBuffer<double> matrix_, factor_, update_, vector_, borders_;
  DeviceBuffer<int> failed_;
};

}  // namespace

Multifrontal::Multifrontal(const FrontPlan& plan, int shared_bytes) {
  std::vector<UpdateTile> tiles;
  for (int level = 0; level < plan.num_levels(); ++level)
    levels_.push_back(MakeRange(plan, level, &tiles));
  tiles_ = arrays_.Upload(tiles);
  view_ = {arrays_.Upload(plan.fronts),
           arrays_.Upload(plan.children),
           arrays_.Upload(plan.entries),
           arrays_.Upload(plan.border_dof),
           arrays_.Upload(plan.child_row),
           arrays_.Upload(plan.source),
           arrays_.Upload(plan.level_front),
           3 * plan.num_vertices(),
           static_cast<int>(plan.entries.size()),
           plan.factor_size,
           plan.update_size,
           plan.vector_size};
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
  const UpdateTile* tiles = SplitsUpdates(all_slots) ? tiles_ : nullptr;
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

std::unique_ptr<LinearSolver> MakeDeviceSolver(const BlockPattern& pattern,
                                               const DeviceInfo& device) {
  CUDA_CHECK(cudaSetDevice(device.index));
  return std::make_unique<DeviceSolver>(
      std::make_shared<Analysis>(pattern, DissectVertices(pattern), device));
}

}  // namespace drape
