// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/device_engine.h"

#include <algorithm>
#include <utility>

namespace drape {

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
  w.records = {arena.Take<FaceRecord>(n * cloth.view().num_faces),
               arena.Take<HingeRecord>(n * cloth.view().num_hinges)};
  w.failed = arena.Take<int>(n);
  w.step = arena.Take<int>(1);
  return w;
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

DeviceEngine::DeviceEngine(std::shared_ptr<const ClothModel> model, const FrontPlan& plan,
                           const DeviceInfo& device, int threads)
    : device_(device), threads_(threads) {
  Bind();
  cloth_ = std::make_unique<DeviceCloth>(std::move(model), plan, device.shared_bytes);
  streams_ = std::make_unique<Streams>();
}

void DeviceEngine::Bind() const { CUDA_CHECK(cudaSetDevice(device_.index)); }

int DeviceEngine::SlotsThatFit(int wanted, const TakeWorkspace& take, std::size_t reserve) const {
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
  int fits = 1, beyond = wanted + 1;
  while (beyond - fits > 1) {
    const int middle = fits + (beyond - fits) / 2;
    (needed(middle) <= usable ? fits : beyond) = middle;
  }
  // Even chunks rather than full ones and a rest.
  const int chunks = (wanted + fits - 1) / fits;
  return (wanted + chunks - 1) / chunks;
}

Arena DeviceEngine::MakeRoom(int slots, const TakeWorkspace& take) {
  Arena measure;
  take(measure, slots);
  memory_.Reserve(measure.used());
  return Arena(&memory_);
}

void DeviceEngine::UploadStarts(std::span<const RolloutInput> batch, double* x, double* v) const {
  const int dofs = cloth_->view().num_dofs();
  std::vector<double> host(batch.size() * dofs);
  const auto upload = [&](Eigen::VectorXd State::*part, double* to) {
    for (std::size_t i = 0; i < batch.size(); ++i)
      cloth_->ToEliminationOrder((batch[i].start->*part).data(), 1, 1, host.data() + i * dofs);
    CopyToDevice<double>(host, to);
  };
  upload(&State::x, x);
  if (v != nullptr) upload(&State::v, v);
}

void DeviceEngine::Clear(void* data, std::size_t bytes) const {
  CUDA_CHECK(cudaMemsetAsync(data, 0, bytes, streams_->main()));
}

void DeviceEngine::LaunchSolveStep(const StepWorkspace& w, const ShapeBatch& group, int first,
                                   double h, cudaStream_t stream) const {
  const std::int64_t dofs = static_cast<std::int64_t>(first) * cloth_->view().num_dofs();
  const StepRecords records = w.RecordsFrom(cloth_->view(), first);
  LaunchElementRecords(cloth_->view(), group, cloth_->law(), records, stream);
  LaunchGatherStep(cloth_->view(), group, records, w.v + dofs, h, MatrixFrom(w, first),
                   w.rhs + dofs, stream);
  cloth_->multifrontal().FactorAndSolve(FactorFrom(w, first), w.rhs + dofs, w.solution + dofs,
                                        group.slots, group.all_slots, stream);
}

void DeviceEngine::LaunchFactorStep(const StepWorkspace& w, const ShapeBatch& group, int first,
                                    double h, double* rhs, cudaStream_t stream) const {
  const StepRecords records = w.RecordsFrom(cloth_->view(), first);
  LaunchElementRecords(cloth_->view(), group, cloth_->law(), records, stream);
  LaunchGatherStep(cloth_->view(), group, records, nullptr, h, MatrixFrom(w, first), nullptr,
                   stream);
  cloth_->multifrontal().FactorAndSolve(FactorFrom(w, first), rhs, rhs, group.slots,
                                        group.all_slots, stream);
}

double* DeviceEngine::MatrixFrom(const StepWorkspace& w, std::int64_t first) const {
  return w.matrix + first * 9 * cloth_->multifrontal().view().num_entries;
}

FactorView DeviceEngine::FactorFrom(const StepWorkspace& w, std::int64_t first) const {
  const PlanView& plan = cloth_->multifrontal().view();
  return {MatrixFrom(w, first), w.factor.From(first, plan.factor_size),
          w.update + first * plan.update_size, w.failed + first};
}

void DeviceEngine::LaunchAdvanceGroup(const StepWorkspace& w, const HistoryView& history, int first,
                                      int slots, double h, cudaStream_t stream) const {
  const std::int64_t dofs = static_cast<std::int64_t>(first) * cloth_->view().num_dofs();
  HistoryView group = history;
  if (history.x != nullptr) {
    group.x += dofs;
    group.v += dofs;
  }
  LaunchAdvance(cloth_->view(), {w.x + dofs, w.v + dofs, w.failed + first}, w.solution + dofs, h,
                group, slots, stream);
}

int DeviceEngine::RunSteps(const Graph& graph, int steps, const std::atomic<bool>* cancel) const {
  constexpr int kStepsAhead = 16;  // of the host, where it must be able to stop
  for (int k = 0; k < steps; ++k) {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return k;
    graph.Launch(streams_->main());
    if (cancel != nullptr && k % kStepsAhead == kStepsAhead - 1) streams_->Synchronize();
  }
  return steps;
}

void DeviceEngine::CollectEnds(const StepWorkspace& w, int steps, int wanted_steps,
                               std::span<RolloutResult* const> results,
                               std::span<char> failed) const {
  const int dofs = cloth_->view().num_dofs();
  std::vector<double> x(results.size() * dofs), v(x.size());
  std::vector<int> flags(results.size());
  streams_->Synchronize();
  CopyToHost<double>(w.x, x);
  CopyToHost<double>(w.v, v);
  CopyToHost<int>(w.failed, flags);
  for (std::size_t i = 0; i < results.size(); ++i) {
    failed[i] = flags[i] != 0;
    RolloutResult& result = *results[i];
    result.status = steps < wanted_steps ? RolloutStatus::kCancelled : RolloutStatus::kOk;
    result.steps = steps;
    result.end.x.resize(dofs);
    result.end.v.resize(dofs);
    cloth_->ToMeshOrder(x.data() + i * dofs, 1, 1, result.end.x.data());
    cloth_->ToMeshOrder(v.data() + i * dofs, 1, 1, result.end.v.data());
  }
}

}  // namespace drape
