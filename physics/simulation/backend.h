// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/statics.h"

namespace drape {

// One rollout of a batch. The pointed-to objects outlive the call. What Rollouts and Equilibria do
// not use they do not read: `tangent` is of Tangents, `adjoint` of Adjoints; null: nothing more.
// Here and in all derivatives by the material the entries are those of MaterialField, in ARCSim's
// convention [MODEL, M9]: half the membrane stiffness, four times the rigidity. Files are in the
// mechanical convention.
struct RolloutInput {
  const MaterialField* material = nullptr;
  const State* start = nullptr;
  const TangentOptions* tangent = nullptr;
  const AdjointOptions* adjoint = nullptr;
};

// Runs batches of rollouts of one model: different materials and starts, one mesh, scene and law.
// Results come in the order of the inputs. Each is a function of its own input and the options
// alone: neither the neighbours, their failures, the size of the batch nor calls before change a
// bit of it, so calls may be joined and split (BatchingBackend). One thread at a time calls a
// backend.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual const ClothModel& model() const = 0;
  virtual int threads() const = 0;  // of the host, at most; ≥ 1

  // recordings: nullptr, or resized to the batch and filled for Adjoints. options.frames: of all
  // rollouts of the batch.
  virtual std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                              const RolloutOptions& options,
                                              std::vector<Recording>* recordings) = 0;
  // weights[i]: weight of each table entry in the 39 columns of rollout i (AddMaterialColumns).
  virtual std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                              std::span<const MaterialField* const> weights,
                                              const RolloutOptions& options) = 0;
  // dL_dx[i]: by the end of rollout i, shape [3V, m_i]; RolloutInput::adjoint has those by frames.
  virtual std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                              std::span<const Recording> recordings,
                                              std::span<const RowMatrix> dL_dx,
                                              const RolloutOptions& options) = 0;

  // Drapes at rest in still air near the starts (their velocities and MaterialField::dynamics do
  // not count).
  virtual std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                                    const EquilibriumOptions& options) = 0;
  // ∂x/∂p of equilibria that are given as the starts, shape [3V, 39] each, or [3V, 46] where
  // RolloutInput::tangent wants the dynamics; empty where K is not positive definite.
  virtual std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) = 0;
  // How these equilibria move, to first order in changes[i] of each table entry, by one solve each;
  // shape [3V] each, empty as above.
  virtual std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) = 0;
  // Gradients of scalars of equilibria that are given as the starts; dL_dx[i]: shape
  // [3V, m_i]. Empty where K is not positive definite.
  virtual std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix> dL_dx) = 0;
};

// The reference implementation: one rollout per thread. threads ≥ 1.
std::unique_ptr<Backend> MakeCpuBackend(std::shared_ptr<const ClothModel> model, int threads);

// Computes the equilibrium that a cloth reaches from rest under a slowly rising load, for scenes
// with a single equilibrium (strips, clamped plates) [MODEL, M37]. Newton's method goes from one
// share of the load to the next, and the increment is shortened where it fails. A share of the load
// is the full load on a cloth that is stiffer by its inverse. `tolerance` refers to the full load.
// When no smaller increment succeeds, which is where a cloth loses its stability, the result of the
// last share that converged is returned with status kNotConverged and this load_share. Iterations
// and factorisations are those of all shares.
EquilibriumResult SolveFromRest(StepSolver& solver, const MaterialField& material,
                                const EquilibriumOptions& options);
EquilibriumResult SolveFromRest(Backend& backend, const MaterialField& material,
                                const EquilibriumOptions& options);

}  // namespace drape
