// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "cuda/engine/equilibria/implicit_solver.h"
#include "cuda/engine/resources/device_resources.h"

namespace drape {

// Drapes at rest on one device, and their derivatives by the implicit function theorem
// (physics/simulation/statics/statics.h). Arguments are as in Backend.
class EquilibriumEngine {
 public:
  explicit EquilibriumEngine(DeviceResources& resources) : resources_(resources) {}

  // All of a batch are treated together; a drape that is at rest leaves it.
  void Equilibria(std::span<const RolloutInput> batch, const EquilibriumOptions& options,
                  std::span<EquilibriumResult> results);
  void Tangents(std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
                std::span<RowMatrix> results);
  // Solves for one right-hand side of each equilibrium.
  void Jvp(std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes,
           std::span<Eigen::VectorXd> results);
  // All dL_dx have the same number of columns.
  void Adjoints(std::span<const RolloutInput> batch, std::span<const RowMatrix* const> dL_dx,
                std::span<std::optional<MaterialGradient>> results);

 private:
  // A chunk on the device, valid until the resources' next batch.
  struct TangentRun {
    const double* dx;          // [3V, columns] a slot
    std::vector<char> solved;  // of each slot
  };
  using VisitTangents =
      std::function<void(std::size_t first, std::size_t count, const TangentRun& run)>;
  // Right-hand sides of a chunk: ∂f/∂p of the shapes.
  using FillRhs = std::function<void(const LaunchContext& on, const ImplicitWorkspace& workspace)>;
  // Solves for chunks of the batch, `columns` right-hand sides each.
  void SolveChunks(std::span<const RolloutInput> batch,
                   std::span<const MaterialField* const> weights, int columns,
                   const FillRhs& fill_rhs, const VisitTangents& visit);

  DeviceResources& resources_;
};

}  // namespace drape
