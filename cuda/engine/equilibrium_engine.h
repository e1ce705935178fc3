// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

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
  DeviceResources& resources_;
};

}  // namespace drape
