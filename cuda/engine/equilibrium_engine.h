// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

// Workspace of the implicit derivatives by slot; step.x: the shapes, step.v: zeros.
struct ImplicitWorkspace {
  StepWorkspace step;
  DerivativeRecords derivatives;
  FactorRecords factors;                         // of the tangents only
  double* mu;                                    // [1]
  double* blocks;                                // −K, [9·num_blocks]
  double *rhs, *x, *before, *residual, *solved;  // [3V, columns]
  double* vectors;                               // [vector_size, columns]
  double *dots, *weights;                        // [columns]

  static ImplicitWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots, int columns,
                                bool tangents) {
    const std::size_t n = slots, numbers = n * cloth.view().num_dofs() * columns;
    const ClothView& view = cloth.view();
    ImplicitWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                     arena.Take<HingeDerivative>(n * view.num_hinges)};
    if (tangents)
      w.factors = {arena.Take<FaceFactors>(n * view.num_faces),
                   arena.Take<HingeFactors>(n * view.num_hinges)};
    w.mu = arena.Take<double>(n);
    w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    for (double** part : {&w.rhs, &w.x, &w.before, &w.residual, &w.solved})
      *part = arena.Take<double>(numbers);
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    w.dots = arena.Take<double>(n * columns);
    w.weights = arena.Take<double>(n * columns);
    return w;
  }
};

// Factors Ks of the batch's shapes, without shift; workspace.step.failed says where it could not.
void FactorStiffness(const DeviceResources& resources, const ImplicitWorkspace& workspace,
                     const ShapeBatch& batch);
// Solves K·X = B or Kᵀ·X = B for workspace.rhs, where its first `used` columns count; true where
// each of them is solved. The workspace has PaddedColumns(used).
std::vector<char> SolveStiffness(const DeviceResources& resources,
                                 const ImplicitWorkspace& workspace, const ShapeBatch& batch,
                                 bool transposed, int used);

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
