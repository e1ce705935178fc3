// SPDX-License-Identifier: Apache-2.0
// Derivatives of drapes at rest by the implicit function theorem
// (physics/simulation/statics/statics.h), in batches.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cuda/engine/device_gradient.h"
#include "cuda/engine/implicit_workspace.h"
#include "cuda/kernels/statics/statics_kernels.h"
#include "physics/linalg/cgw_recurrence.h"

namespace drape {

// dx in workspace.x where solved.
struct DeviceEngine::ImplicitRun {
  ImplicitWorkspace workspace;
  std::vector<char> solved;
};

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
  bool GoesOn() const {
    return std::any_of(each_.begin(), each_.end(),
                       [](const CgwRecurrence& r) { return r.status() == CgwStatus::kGoOn; });
  }
  bool IsSolved(int slot) const { return each_[slot].status() == CgwStatus::kSolved; }

  // ω; −1 where a column stays as it is.
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

void DeviceEngine::FactorStiffness(const ImplicitWorkspace& w, const ShapeBatch& batch) const {
  const ClothView& cloth = cloth_->view();
  const cudaStream_t stream = streams_->main();
  Clear(w.step.failed, batch.slots * sizeof(int));
  Clear(w.step.v, sizeof(double) * batch.slots * cloth.num_dofs());
  Clear(w.mu, sizeof(double) * batch.slots);
  LaunchDerivativeRecords(cloth, batch, cloth_->law(), w.step.v, 1.0, w.derivatives, stream);
  LaunchGatherDerivative(cloth, w.derivatives, 1.0, w.blocks, batch.slots, stream);
  LaunchGatherStiffness(cloth, batch, w.derivatives, {nullptr, nullptr, w.mu, 0.0}, w.step.matrix,
                        stream);
  cloth_->multifrontal().FactorAndSolve(FactorFrom(w.step, 0), nullptr, nullptr, batch.slots,
                                        batch.slots, stream);
}

std::vector<char> DeviceEngine::SolveStiffness(const ImplicitWorkspace& w, const ShapeBatch& batch,
                                               bool transposed, int used) const {
  const ClothView& cloth = cloth_->view();
  const int slots = batch.slots, dofs = cloth.num_dofs(), columns = PaddedColumns(used);
  const std::int64_t count = static_cast<std::int64_t>(slots) * dofs * columns;
  const cudaStream_t stream = streams_->main();
  std::vector<double> numbers(slots * columns);
  const auto dots = [&](const double* a, const double* b) {
    LaunchColumnDots(dofs, a, b, w.dots, columns, slots, stream);
    streams_->Synchronize();
    CopyToHost<double>(w.dots, numbers);
  };
  dots(w.rhs, w.rhs);
  Recurrences recurrences(numbers, slots, columns, used);
  Clear(w.x, count * sizeof(double));
  Clear(w.before, count * sizeof(double));
  LaunchCopy(w.rhs, w.residual, count, stream);
  while (recurrences.GoesOn()) {
    cloth_->multifrontal().Solve(w.step.factor, w.residual, w.solved, w.vectors, columns, slots,
                                 stream);
    dots(w.residual, w.solved);
    CopyToDevice<double>(recurrences.Weights(numbers), w.weights);
    LaunchCgwAdvance(dofs, w.weights, w.solved, w.before, w.x, columns, slots, stream);
    LaunchCopy(w.rhs, w.residual, count, stream);
    LaunchMultiply(cloth, w.blocks, transposed, w.x, w.residual, columns, slots, stream);
    dots(w.residual, w.residual);
    recurrences.Judge(numbers);
  }
  std::vector<int> failed(slots);
  CopyToHost<int>(w.step.failed, failed);
  std::vector<char> solved(slots);
  for (int s = 0; s < slots; ++s) solved[s] = failed[s] == 0 && recurrences.IsSolved(s);
  return solved;
}

void DeviceEngine::ForEachImplicitChunk(std::size_t count, const ChunkWork& work) {
  Bind();
  const int most = SlotsThatFit(static_cast<int>(count), [&](Arena& arena, int slots) {
    ImplicitWorkspace::Take(arena, *cloth_, slots, kPaddedEntries, true);
  });
  for (std::size_t first = 0; first < count; first += most)
    work(first, std::min<std::size_t>(most, count - first));
}

void DeviceEngine::EquilibriumTangents(std::span<const RolloutInput> batch,
                                       std::span<const MaterialField* const> weights,
                                       std::span<RowMatrix> results) {
  const std::size_t columns = std::size_t{kPaddedEntries} * cloth_->view().num_dofs();
  ForEachImplicitChunk(batch.size(), [&](std::size_t first, std::size_t count) {
    const ImplicitRun run =
        RunImplicitTangents(batch.subspan(first, count), weights.subspan(first, count));
    std::vector<double> host(count * columns);
    CopyToHost<double>(run.workspace.x, host);
    for (std::size_t i = 0; i < count; ++i) {
      RowMatrix& result = results[first + i];
      result = RowMatrix();
      if (!run.solved[i]) continue;
      result.resize(cloth_->view().num_dofs(), kMaterialEntries);
      cloth_->ToMeshOrder(host.data() + i * columns, kMaterialEntries, kPaddedEntries,
                          result.data());
    }
  });
}

void DeviceEngine::EquilibriumReadoutTangents(std::span<const RolloutInput> batch,
                                              std::span<const MaterialField* const> weights,
                                              const Readout& readout,
                                              std::span<LinearReadout> results) {
  ForEachImplicitChunk(batch.size(), [&](std::size_t first, std::size_t count) {
    const ImplicitRun run =
        RunImplicitTangents(batch.subspan(first, count), weights.subspan(first, count));
    std::vector<const Eigen::VectorXd*> shapes;
    std::vector<LinearReadout*> reads;
    for (std::size_t i = 0; i < count; ++i) {
      shapes.push_back(run.solved[i] ? &batch[first + i].start->x : nullptr);
      reads.push_back(&results[first + i]);
    }
    ReadTangents({run.workspace.step.x, run.workspace.x, shapes}, ReadoutFrom(readout, first),
                 reads);
  });
}

DeviceEngine::ImplicitRun DeviceEngine::RunImplicitTangents(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) {
  const int slots = static_cast<int>(batch.size());
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, *cloth_, n, kPaddedEntries, true);
  };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  std::vector<const MaterialField*> fields;
  for (const RolloutInput& input : batch) fields.push_back(input.material);
  const DeviceMaterials materials(fields), scales(weights);
  UploadStarts(batch, w.step.x, nullptr);
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  FactorStiffness(w, shapes);
  LaunchFactorRecords(cloth_->view(), shapes, cloth_->law(), scales.views(), w.step.v, 1.0,
                      w.factors, streams_->main());
  LaunchTangentRhs(cloth_->view(), shapes, w.factors, nullptr, nullptr, w.rhs, streams_->main());
  return {w, SolveStiffness(w, shapes, false, kPaddedEntries)};
}

void DeviceEngine::EquilibriumAdjoints(std::span<const RolloutInput> batch,
                                       std::span<const RowMatrix* const> seeds,
                                       std::span<std::optional<MaterialGradient>> results) {
  Bind();
  const int m = PaddedColumns(static_cast<int>(seeds[0]->cols()));
  const ClothView& cloth = cloth_->view();
  const std::size_t gradient =
      sizeof(double) * m *
      (kStretchEntries * std::size_t{1} * cloth.num_faces + kBendEntries * cloth.num_hinges);
  const int most = SlotsThatFit(
      static_cast<int>(batch.size()),
      [&](Arena& arena, int slots) { ImplicitWorkspace::Take(arena, *cloth_, slots, m, false); },
      gradient);
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    EquilibriumAdjointChunk(batch.subspan(first, count), seeds.subspan(first, count),
                            results.subspan(first, count));
  }
}

void DeviceEngine::EquilibriumAdjointChunk(std::span<const RolloutInput> batch,
                                           std::span<const RowMatrix* const> seeds,
                                           std::span<std::optional<MaterialGradient>> results) {
  const int slots = static_cast<int>(batch.size()), dofs = cloth_->view().num_dofs();
  const int seeded = static_cast<int>(seeds[0]->cols()), m = PaddedColumns(seeded);
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, *cloth_, n, m, false);
  };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  std::vector<const MaterialField*> fields;
  std::vector<double> host(static_cast<std::size_t>(slots) * dofs * m);
  for (int i = 0; i < slots; ++i) {
    fields.push_back(batch[i].material);
    cloth_->ToEliminationOrder(seeds[i]->data(), seeded, m,
                               host.data() + std::size_t{1} * i * dofs * m);
  }
  const DeviceMaterials materials(fields);
  DeviceGradient gradient(batch, cloth_->view().num_faces, cloth_->view().num_hinges, m);
  UploadStarts(batch, w.step.x, nullptr);
  CopyToDevice<double>(host, w.rhs);
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
  FactorStiffness(w, shapes);
  const std::vector<char> solved = SolveStiffness(w, shapes, true, seeded);
  LaunchAdjointMaterial(cloth_->view(), shapes, cloth_->law(), w.step.v, 1.0, w.x, gradient.From(0),
                        m, streams_->main());
  streams_->Synchronize();
  for (int i = 0; i < slots; ++i)
    results[i] = solved[i] ? std::optional(gradient.Collect(batch[i], i, seeded)) : std::nullopt;
}

}  // namespace drape
