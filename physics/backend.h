// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/statics.h"

namespace drape {

// One rollout of a batch. The pointed-to objects outlive the call.
struct RolloutInput {
  const MaterialField* material = nullptr;
  const State* start = nullptr;
};

// What a loss reads of a shape, to first order: ∂r/∂x, shape [K, 3V] with the same K for each
// rollout of a batch. Asked for the end of rollout i, from several threads at a time.
using Readout = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using ReadoutOf = std::function<Readout(std::size_t i, const Eigen::VectorXd& x_end)>;

struct ReadoutTangent {
  RolloutResult rollout;
  RowMatrix dr;  // ∂r/∂x_end · ∂x_end/∂p, shape [K, 39]; empty when the rollout failed
};

// Runs batches of rollouts of one model: different materials and starts, one mesh, scene and law.
// Results come in the order of the inputs. Each is a function of its own input and the options alone:
// neither the neighbours, their failures, the size of the batch nor calls before change a bit of it,
// so calls may be joined and split (GatheredTask). One thread at a time calls a backend.
class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual const ClothModel& model() const = 0;

  // recordings: nullptr, or resized to the batch and filled for Adjoints.
  virtual std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                              const RolloutOptions& options,
                                              std::vector<Recording>* recordings) = 0;
  // weights[i]: weight of each table entry in the 39 columns of rollout i (AddMaterialColumns).
  virtual std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                              std::span<const MaterialField* const> weights,
                                              const RolloutOptions& options) = 0;
  // The same where only what `readout` reads is wanted: little comes back from a device.
  virtual std::vector<ReadoutTangent> ReadoutTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
      const RolloutOptions& options, const ReadoutOf& readout);
  // seeds[i]: ∂L/∂x_end of rollout i, shape [3V, m_i].
  virtual std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                              std::span<const Recording> recordings,
                                              std::span<const RowMatrix> seeds,
                                              const RolloutOptions& options) = 0;

  // Drapes at rest near the starts (their velocities do not count).
  virtual std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                                    const EquilibriumOptions& options) = 0;
  // ∂x/∂p of equilibria that are given as the starts, shape [3V, 39] each; empty where K is not
  // positive definite.
  virtual std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) = 0;
  // How these equilibria move, to first order in changes[i] of each table entry; shape [3V] each,
  // empty as above.
  virtual std::vector<Eigen::VectorXd> EquilibriumDirections(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes);
  // Gradients of scalars of equilibria that are given as the starts; seeds[i]: ∂L/∂x, shape
  // [3V, m_i]. None where K is not positive definite.
  virtual std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix> seeds) = 0;
};

// The sequential truth: one rollout a thread. threads ≥ 1.
std::unique_ptr<Backend> MakeCpuBackend(std::shared_ptr<const ClothModel> model, int threads);

}  // namespace drape
