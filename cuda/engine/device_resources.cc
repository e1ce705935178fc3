// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/device_resources.h"

#include <algorithm>
#include <utility>

#include "cuda/kernels/element_kernels.h"

namespace drape {
namespace {

void AddRows(std::span<const double> rows, int columns, RowMatrix& sum) {
  const std::int64_t count = static_cast<std::int64_t>(rows.size()) / columns;
  for (std::int64_t r = 0; r < count; ++r)
    for (Eigen::Index j = 0; j < sum.cols(); ++j) sum(r % sum.rows(), j) += rows[r * columns + j];
}

}  // namespace

DeviceResources::DeviceResources(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                                 const DeviceInfo& device, int threads)
    : device_(device), threads_(threads) {
  Bind();
  cloth_ = std::make_unique<DeviceCloth>(std::move(model), plan, device.shared_bytes);
  streams_ = std::make_unique<Streams>();
}

void DeviceResources::Bind() const { CUDA_CHECK(cudaSetDevice(device_.index)); }

std::size_t DeviceResources::FreeBytes() const {
  Bind();
  return QueryMemory().free + memory_.bytes();
}

int DeviceResources::SlotsThatFit(int wanted, const TakeWorkspace& take,
                                  std::size_t reserve) const {
  constexpr double kUsable = 0.9;  // the rest is for the driver, graphs and other programs
  const MemoryStatus memory = QueryMemory();
  const auto usable = static_cast<std::size_t>(kUsable * (memory.free + memory_.bytes()));
  const auto needed = [&](int slots) {
    Arena measure;
    take(measure, slots);
    return measure.used() + slots * reserve;
  };
  if (needed(1) > usable)
    throw DeviceMemoryError("one rollout of this mesh", needed(1), usable, memory.total);
  int fits = 1, too_many = wanted + 1;
  while (too_many - fits > 1) {
    const int middle = fits + (too_many - fits) / 2;
    (needed(middle) <= usable ? fits : too_many) = middle;
  }
  // Even chunks rather than full ones and a rest.
  const int chunks = (wanted + fits - 1) / fits;
  return (wanted + chunks - 1) / chunks;
}

void DeviceResources::ForEachChunk(std::size_t count, const TakeWorkspace& take,
                                   std::size_t reserve, const ChunkWork& work) const {
  Bind();
  const int most = SlotsThatFit(static_cast<int>(count), take, reserve);
  for (std::size_t first = 0; first < count; first += most)
    work(first, std::min<std::size_t>(most, count - first));
}

void DeviceResources::Allocate(int slots, const TakeWorkspace& take) {
  Arena measure;
  take(measure, slots);
  memory_.Reserve(measure.used());
  Arena arena(&memory_);
  take(arena, slots);
}

void DeviceResources::UploadStarts(std::span<const RolloutInput> batch, double* x, double* v) {
  const std::size_t dofs = view().num_dofs(), size = batch.size() * dofs;
  const std::span<double> host = staging_.Take(size);
  const auto upload = [&](Eigen::VectorXd State::*part, double* to) {
#pragma omp parallel for num_threads(threads_)
    for (std::size_t i = 0; i < batch.size(); ++i)
      cloth_->ToEliminationOrder((batch[i].start->*part).data(), 1, 1, host.data() + i * dofs);
    CUDA_CHECK(
        cudaMemcpyAsync(to, host.data(), host.size_bytes(), cudaMemcpyHostToDevice, stream()));
    streams_->Synchronize();
  };
  upload(&State::x, x);
  if (v != nullptr) upload(&State::v, v);
}

void DeviceResources::DownloadEnds(const double* x, const double* v,
                                   std::span<RolloutResult* const> results) {
  const std::size_t dofs = view().num_dofs(), size = results.size() * dofs;
  const std::span<double> host = staging_.Take(size);
  const auto download = [&](const double* from, Eigen::VectorXd State::*part) {
    CUDA_CHECK(
        cudaMemcpyAsync(host.data(), from, host.size_bytes(), cudaMemcpyDeviceToHost, stream()));
    streams_->Synchronize();
#pragma omp parallel for num_threads(threads_)
    for (std::size_t i = 0; i < results.size(); ++i) {
      Eigen::VectorXd& to = results[i]->end.*part;
      to.resize(static_cast<Eigen::Index>(dofs));
      cloth_->ToMeshOrder(host.data() + i * dofs, 1, 1, to.data());
    }
  };
  download(x, &State::x);
  download(v, &State::v);
}

void DeviceResources::Clear(void* data, std::size_t bytes) const {
  CUDA_CHECK(cudaMemsetAsync(data, 0, bytes, stream()));
}

int DeviceResources::RunSteps(const Graph& graph, int steps,
                              const std::atomic<bool>* cancel) const {
  constexpr int kStepsAhead = 16;  // of the host, where it must be able to stop
  for (int k = 0; k < steps; ++k) {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return k;
    graph.Launch(stream());
    if (cancel != nullptr && k % kStepsAhead == kStepsAhead - 1) streams_->Synchronize();
  }
  return steps;
}

std::vector<const MaterialField*> CollectMaterials(std::span<const RolloutInput> batch) {
  std::vector<const MaterialField*> materials;
  for (const RolloutInput& input : batch) materials.push_back(input.material);
  return materials;
}

ShapeBatch SliceBatch(const ShapeBatch& batch, int first, int slots, int num_dofs) {
  ShapeBatch group = batch;
  group.slots = slots;
  if (batch.rollout != nullptr) {
    group.rollout += first;
  } else {
    group.material += first;
    group.x += static_cast<std::int64_t>(first) * num_dofs;
  }
  return group;
}

DeviceGradient::DeviceGradient(std::span<const RolloutInput> batch, int faces, int hinges,
                               int columns)
    : columns_(columns), stretch_start_{0}, bend_start_{0} {
  for (const RolloutInput& input : batch) {
    const std::int64_t stretch = GradientRows(faces, input.material->stretch.size() > 1);
    const std::int64_t bend = GradientRows(hinges, input.material->bend.size() > 1);
    stretch_start_.push_back(stretch_start_.back() + stretch * kStretchEntries * columns);
    bend_start_.push_back(bend_start_.back() + bend * kBendEntries * columns);
  }
  stretch_ = DeviceBuffer<double>(stretch_start_.back());
  bend_ = DeviceBuffer<double>(bend_start_.back());
  stretch_starts_ = DeviceBuffer<std::int64_t>(stretch_start_);
  bend_starts_ = DeviceBuffer<std::int64_t>(bend_start_);
  Clear(stretch_);
  Clear(bend_);
}

GradientView DeviceGradient::From(int first) {
  return {stretch_.data(), bend_.data(), stretch_starts_.data() + first,
          bend_starts_.data() + first};
}

MaterialGradient DeviceGradient::Collect(const RolloutInput& input, int i, int m) {
  if (host_stretch_.empty() && host_bend_.empty()) {
    host_stretch_ = Download(stretch_.data(), stretch_.size());
    host_bend_ = Download(bend_.data(), bend_.size());
  }
  MaterialGradient gradient = MaterialGradient::Zero(*input.material, m);
  const auto part = [&](const std::vector<double>& all, const std::vector<std::int64_t>& start) {
    return std::span(all).subspan(start[i], start[i + 1] - start[i]);
  };
  AddRows(part(host_stretch_, stretch_start_), columns_, gradient.stretch);
  AddRows(part(host_bend_, bend_start_), columns_, gradient.bend);
  return gradient;
}

StepWorkspace StepWorkspace::Take(Arena& arena, const DeviceCloth& cloth, int slots) {
  const std::size_t n = slots, dofs = n * cloth.view().num_dofs();
  const PlanView& plan = cloth.multifrontal().view();
  StepWorkspace w{};
  w.x = arena.Take<double>(dofs);
  w.v = arena.Take<double>(dofs);
  w.matrix = arena.Take<double>(n * 9 * plan.num_entries);
  w.factor = {arena.Take<double>(n * plan.factor_size)};
  w.update = arena.Take<double>(n * plan.update_size);
  w.rhs = arena.Take<double>(dofs);
  w.solution = arena.Take<double>(dofs);
  w.damped = arena.Take<double>(dofs);
  w.records = {arena.Take<FaceRecord>(n * cloth.view().num_faces),
               arena.Take<HingeRecord>(n * cloth.view().num_hinges)};
  w.failed = arena.Take<int>(n);
  w.step = arena.Take<int>(1);
  return w;
}

void LaunchSolveStep(const LaunchContext& on, const Multifrontal& multifrontal,
                     const StepWorkspace& w, int first, double h) {
  const std::int64_t dofs = static_cast<std::int64_t>(first) * on.cloth.num_dofs();
  const StepRecords records = w.records.From(on.cloth, first);
  LaunchElementRecords(on, records);
  LaunchGatherStep(on, records, w.v + dofs, h, w.MatrixFrom(multifrontal.view(), first),
                   w.rhs + dofs);
  multifrontal.FactorAndSolve(w.FactorFrom(multifrontal.view(), first), w.rhs + dofs,
                              w.solution + dofs, on.batch.slots, on.batch.all_slots, on.stream);
}

void LaunchFactorStep(const LaunchContext& on, const Multifrontal& multifrontal,
                      const StepWorkspace& w, const double* v, int first, double h, double* rhs) {
  const StepRecords records = w.records.From(on.cloth, first);
  LaunchElementRecords(on, records);
  LaunchGatherStep(on, records, v, h, w.MatrixFrom(multifrontal.view(), first), nullptr);
  multifrontal.FactorAndSolve(w.FactorFrom(multifrontal.view(), first), rhs, rhs, on.batch.slots,
                              on.batch.all_slots, on.stream);
}

void LaunchAdvanceGroup(const LaunchContext& on, const StepWorkspace& w, int first, double h,
                        BlockedMove blocked, const HistoryView& history) {
  const std::int64_t dofs = static_cast<std::int64_t>(first) * on.cloth.num_dofs();
  HistoryView group = history;
  if (history.x != nullptr) {
    group.x += dofs;
    group.v += dofs;
  }
  LaunchShortenMoves(on, {nullptr, h}, w.solution + dofs,
                     blocked == BlockedMove::kFails ? w.failed + first : nullptr);
  LaunchAdvance(on, {w.x + dofs, w.v + dofs, w.failed + first}, w.solution + dofs, h, group);
}

}  // namespace drape
