// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/resources/step_workspace.h"

#include "cuda/kernels/contact_kernels.h"

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

void LaunchSolveStep(const LaunchContext& on, const Multifrontal& multifrontal,
                     const StepWorkspace& w, int first, double h) {
  const std::int64_t dofs = static_cast<std::int64_t>(first) * on.cloth.num_dofs();
  const StepRecords records = w.RecordsFrom(on.cloth, first);
  LaunchElementRecords(on, records);
  LaunchGatherStep(on, records, w.v + dofs, h, w.MatrixFrom(multifrontal.view(), first),
                   w.rhs + dofs);
  multifrontal.FactorAndSolve(w.FactorFrom(multifrontal.view(), first), w.rhs + dofs,
                              w.solution + dofs, on.batch.slots, on.batch.all_slots, on.stream);
}

void LaunchFactorStep(const LaunchContext& on, const Multifrontal& multifrontal,
                      const StepWorkspace& w, int first, double h, double* rhs) {
  const StepRecords records = w.RecordsFrom(on.cloth, first);
  LaunchElementRecords(on, records);
  LaunchGatherStep(on, records, nullptr, h, w.MatrixFrom(multifrontal.view(), first), nullptr);
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
