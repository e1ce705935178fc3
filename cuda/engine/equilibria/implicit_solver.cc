// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/equilibria/implicit_solver.h"

#include <algorithm>
#include <cmath>

#include "cuda/engine/resources/device_resources.h"
#include "cuda/kernels/statics/statics_kernels.h"
#include "physics/linalg/cgw_recurrence.h"

namespace drape {
namespace {

// The recurrences of a batch, one a slot: numbers of their active columns from and to [slots,
// columns].
class Recurrences {
 public:
  Recurrences(const std::vector<double>& squares, int slots, int columns, int used)
      : columns_(columns) {
    for (int s = 0; s < slots; ++s) {
      std::vector<double> norms(used);
      for (int j = 0; j < used; ++j) norms[j] = std::sqrt(squares[s * columns + j]);
      each_.emplace_back(norms);
    }
  }
  bool HasActive() const {
    return std::any_of(each_.begin(), each_.end(),
                       [](const CgwRecurrence& r) { return r.status() == CgwStatus::kGoOn; });
  }
  bool IsSolved(int slot) const { return each_[slot].status() == CgwStatus::kSolved; }

  // ω; −1 for columns that are not active.
  std::vector<double> Weights(const std::vector<double>& dots) {
    std::vector<double> weights(dots.size(), -1.0);
    ForEachActive([&](CgwRecurrence& r, int first) {
      const auto of_active = r.Weights(Active(r, dots, first));
      for (std::size_t k = 0; k < of_active.size(); ++k)
        weights[first + r.active()[k]] = of_active[k];
    });
    return weights;
  }
  void Judge(const std::vector<double>& squares) {
    ForEachActive([&](CgwRecurrence& r, int first) {
      std::vector<double> norms = Active(r, squares, first);
      for (double& norm : norms) norm = std::sqrt(norm);
      r.Judge(norms);
    });
  }

 private:
  template <class Work>
  void ForEachActive(const Work& work) {
    for (std::size_t s = 0; s < each_.size(); ++s)
      if (each_[s].status() == CgwStatus::kGoOn) work(each_[s], static_cast<int>(s) * columns_);
  }
  static std::vector<double> Active(const CgwRecurrence& r, const std::vector<double>& all,
                                    int first) {
    std::vector<double> active;
    for (const int j : r.active()) active.push_back(all[first + j]);
    return active;
  }

  int columns_;
  std::vector<CgwRecurrence> each_;
};

}  // namespace

void FactorStiffness(const DeviceResources& resources, const ImplicitWorkspace& w,
                     const ShapeBatch& batch) {
  const Multifrontal& multifrontal = resources.cloth().multifrontal();
  const LaunchContext on = resources.On(batch);
  resources.Clear(w.step.failed, batch.slots * sizeof(int));
  resources.Clear(w.step.v, sizeof(double) * batch.slots * on.cloth.num_dofs());
  resources.Clear(w.mu, sizeof(double) * batch.slots);
  LaunchDerivativeRecords(on, w.step.v, 1.0, w.derivatives);
  LaunchGatherDerivative(on, w.derivatives, w.step.v, 1.0, w.blocks);
  LaunchGatherStiffness(on, w.derivatives, {nullptr, nullptr, w.mu, 0.0}, w.step.matrix);
  multifrontal.FactorAndSolve(w.step.FactorFrom(multifrontal.view(), 0), nullptr, nullptr,
                              batch.slots, batch.slots, on.stream);
}

std::vector<char> SolveStiffness(const DeviceResources& resources, const ImplicitWorkspace& w,
                                 const ShapeBatch& batch, bool transposed, int used) {
  const Multifrontal& multifrontal = resources.cloth().multifrontal();
  const LaunchContext on = resources.On(batch);
  const int slots = batch.slots, columns = PaddedColumns(used);
  const std::int64_t count = static_cast<std::int64_t>(slots) * on.cloth.num_dofs() * columns;
  std::vector<double> numbers(slots * columns);
  const auto dots = [&](const double* a, const double* b) {
    LaunchColumnDots(on, a, b, w.dots, columns);
    resources.streams().Synchronize();
    CopyToHost<double>(w.dots, numbers);
  };
  dots(w.rhs, w.rhs);
  Recurrences recurrences(numbers, slots, columns, used);
  resources.Clear(w.x, count * sizeof(double));
  resources.Clear(w.before, count * sizeof(double));
  LaunchCopy(w.rhs, w.residual, count, on.stream);
  while (recurrences.HasActive()) {
    multifrontal.Solve(w.step.factor, {w.residual, w.solved, w.vectors, columns}, slots, on.stream);
    dots(w.residual, w.solved);
    CopyToDevice<double>(recurrences.Weights(numbers), w.weights);
    LaunchCgwAdvance(on, w.weights, w.solved, w.before, w.x, columns);
    LaunchCopy(w.rhs, w.residual, count, on.stream);
    LaunchMultiply(on, w.blocks, transposed, w.x, w.residual, columns);
    dots(w.residual, w.residual);
    recurrences.Judge(numbers);
  }
  std::vector<int> failed(slots);
  CopyToHost<int>(w.step.failed, failed);
  std::vector<char> solved(slots);
  for (int s = 0; s < slots; ++s) solved[s] = failed[s] == 0 && recurrences.IsSolved(s);
  return solved;
}

}  // namespace drape
