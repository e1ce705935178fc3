// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/equilibria/equilibrium_engine.h"

#include <utility>

#include "cuda/engine/equilibria/batch_newton.h"
#include "cuda/engine/resources/device_gradient.h"

namespace drape {

void EquilibriumEngine::Equilibria(std::span<const RolloutInput> batch,
                                   const EquilibriumOptions& options,
                                   std::span<EquilibriumResult> results) {
  resources_.ForEachChunk(
      batch.size(),
      [&](Arena& arena, int slots) { TakeNewtonWorkspace(arena, resources_.cloth(), slots); }, 0,
      [&](std::size_t first, std::size_t count) {
        FindEquilibria(resources_, batch.subspan(first, count), options,
                       results.subspan(first, count));
      });
}

void EquilibriumEngine::SolveChunks(std::span<const RolloutInput> batch,
                                    std::span<const MaterialField* const> weights, int columns,
                                    const FillRhs& fill_rhs, const VisitTangents& visit) {
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, resources_.cloth(), n, columns, true);
  };
  resources_.ForEachChunk(batch.size(), take, 0, [&](std::size_t first, std::size_t count) {
    const int slots = static_cast<int>(count);
    const auto chunk = batch.subspan(first, count);
    resources_.Allocate(slots, take);
    const DeviceMaterials materials(CollectMaterials(chunk)), scales(weights.subspan(first, count));
    resources_.UploadStarts(chunk, w.step.x, nullptr);
    const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
    const LaunchContext on = resources_.On(shapes);
    FactorStiffness(resources_, w, shapes);
    LaunchFactorRecords(on, scales.views(), w.step.v, 1.0, w.factors);
    fill_rhs(on, w);
    visit(first, count, {w.x, SolveStiffness(resources_, w, shapes, false, columns)});
  });
}

void EquilibriumEngine::Tangents(std::span<const RolloutInput> batch,
                                 std::span<const MaterialField* const> weights,
                                 std::span<RowMatrix> results) {
  const int dofs = resources_.view().num_dofs();
  const std::size_t columns = std::size_t{kPaddedEntries} * dofs;
  SolveChunks(
      batch, weights, kPaddedEntries,
      [](const LaunchContext& on, const ImplicitWorkspace& w) {
        LaunchTangentRhs(on, w.factors, nullptr, nullptr, w.rhs);
      },
      [&](std::size_t first, std::size_t count, const TangentRun& run) {
        std::vector<double> host(count * columns);
        CopyToHost<double>(run.dx, host);
        for (std::size_t i = 0; i < count; ++i) {
          RowMatrix& result = results[first + i];
          result = RowMatrix();
          if (!run.solved[i]) continue;
          result.resize(dofs, kMaterialEntries);
          resources_.cloth().ToMeshOrder(host.data() + i * columns, kMaterialEntries,
                                         kPaddedEntries, result.data());
        }
      });
}

void EquilibriumEngine::Jvp(std::span<const RolloutInput> batch,
                            std::span<const MaterialField* const> changes,
                            std::span<Eigen::VectorXd> results) {
  const std::size_t dofs = resources_.view().num_dofs();
  SolveChunks(
      batch, changes, 1,
      [](const LaunchContext& on, const ImplicitWorkspace& w) {
        LaunchDirectionRhs(on, w.factors, w.rhs);
      },
      [&](std::size_t first, std::size_t count, const TangentRun& run) {
        std::vector<double> host(count * dofs);
        CopyToHost<double>(run.dx, host);
        for (std::size_t i = 0; i < count; ++i) {
          Eigen::VectorXd& result = results[first + i];
          result.resize(run.solved[i] ? dofs : 0);
          if (run.solved[i])
            resources_.cloth().ToMeshOrder(host.data() + i * dofs, 1, 1, result.data());
        }
      });
}

void EquilibriumEngine::Adjoints(std::span<const RolloutInput> batch,
                                 std::span<const RowMatrix* const> dL_dx,
                                 std::span<std::optional<MaterialGradient>> results) {
  const DeviceCloth& cloth = resources_.cloth();
  const ClothView& view = cloth.view();
  const int used = static_cast<int>(dL_dx[0]->cols()), m = PaddedColumns(used);
  const std::size_t columns = std::size_t{1} * m * view.num_dofs();
  ImplicitWorkspace w{};
  const auto take = [&](Arena& arena, int n) {
    w = ImplicitWorkspace::Take(arena, cloth, n, m, false);
  };
  const auto solve = [&](std::size_t first, std::size_t count) {
    const int slots = static_cast<int>(count);
    const auto chunk = batch.subspan(first, count);
    resources_.Allocate(slots, take);
    std::vector<double> host(count * columns);
    for (std::size_t i = 0; i < count; ++i)
      cloth.ToEliminationOrder(dL_dx[first + i]->data(), used, m, host.data() + i * columns);
    const DeviceMaterials materials(CollectMaterials(chunk));
    DeviceGradient gradient(chunk, view.num_faces, view.num_hinges, m);
    resources_.UploadStarts(chunk, w.step.x, nullptr);
    CopyToDevice<double>(host, w.rhs);
    const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.step.x};
    FactorStiffness(resources_, w, shapes);
    const std::vector<char> solved = SolveStiffness(resources_, w, shapes, true, used);
    LaunchAdjointMaterial(resources_.On(shapes), w.step.v, 1.0, w.x, gradient.From(0), m);
    resources_.streams().Synchronize();
    for (int i = 0; i < slots; ++i)
      results[first + i] =
          solved[i] ? std::optional(gradient.Collect(chunk[i], i, used)) : std::nullopt;
  };
  resources_.ForEachChunk(batch.size(), take, GradientBytes(view, m), solve);
}

}  // namespace drape
