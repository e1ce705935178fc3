// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/host_readouts.h"

#include <optional>
#include <utility>

namespace drape {
namespace {

LinearReadout ReadTangent(const Readout& readout, std::size_t i, const Eigen::VectorXd& x,
                          const RowMatrix& dx) {
  LinearReadout read;
  ReadoutJacobian dr_dx;
  if (!readout.Read(i, x, &read.r, &dr_dx)) return {};
  read.dr = dr_dx * dx;
  return read;
}

// The loss of rollout i at x, and ∂L/∂x, shape [3V, 1].
std::optional<double> EvaluateLoss(const ReadoutLoss& loss, std::size_t i, const Eigen::VectorXd& x,
                                   RowMatrix* dL_dx) {
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  if (!loss.readout->Read(i, x, &r, &dr_dx)) return std::nullopt;
  const Eigen::VectorXd residual = (r - *loss.targets[i]) / loss.sigma;
  *dL_dx = dr_dx.transpose() * (residual / loss.sigma);
  return 0.5 * residual.squaredNorm();
}

// The gradients of those results that have a loss, whose recordings and ∂L/∂x are moved from.
void AddGradients(Backend& backend, std::span<const RolloutInput> batch,
                  const RolloutOptions& options, std::vector<Recording>* recordings,
                  std::vector<RowMatrix>* dL_dx, std::vector<LossGradient>* results) {
  std::vector<LossGradient*> members;
  std::vector<RolloutInput> inputs;
  std::vector<Recording> kept;
  std::vector<RowMatrix> kept_dL_dx;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (!(*results)[i].loss) continue;
    members.push_back(&(*results)[i]);
    inputs.push_back(batch[i]);
    kept.push_back(std::move((*recordings)[i]));
    kept_dL_dx.push_back(std::move((*dL_dx)[i]));
  }
  std::vector<AdjointResult> adjoints = backend.Adjoints(inputs, kept, kept_dL_dx, options);
  for (std::size_t k = 0; k < members.size(); ++k) {
    members[k]->status = adjoints[k].status;
    members[k]->material = std::move(adjoints[k].material);
    if (adjoints[k].status != RolloutStatus::kOk) *members[k] = {adjoints[k].status, {}, {}};
  }
}

}  // namespace

std::vector<ReadoutTangent> ReadTangents(Backend& backend, std::span<const RolloutInput> batch,
                                         std::span<const MaterialField* const> weights,
                                         const RolloutOptions& options, const Readout& readout) {
  std::vector<TangentResult> tangents = backend.Tangents(batch, weights, options);
  std::vector<ReadoutTangent> results(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(backend.threads())
  for (std::size_t i = 0; i < batch.size(); ++i) {
    results[i].rollout = std::move(tangents[i].rollout);
    if (results[i].rollout.status == RolloutStatus::kOk)
      results[i].read = ReadTangent(readout, i, results[i].rollout.end.x, tangents[i].dx);
  }
  return results;
}

std::vector<Eigen::VectorXd> SumEquilibriumTangents(Backend& backend,
                                                    std::span<const RolloutInput> batch,
                                                    std::span<const MaterialField* const> changes) {
  std::vector<Eigen::VectorXd> directions;
  for (const RowMatrix& tangent : backend.EquilibriumTangents(batch, changes))
    directions.push_back(tangent.rowwise().sum());
  return directions;
}

std::vector<LinearReadout> ReadEquilibriumTangents(Backend& backend,
                                                   std::span<const RolloutInput> batch,
                                                   std::span<const MaterialField* const> weights,
                                                   const Readout& readout) {
  const std::vector<RowMatrix> tangents = backend.EquilibriumTangents(batch, weights);
  std::vector<LinearReadout> results(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(backend.threads())
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (tangents[i].size() > 0)
      results[i] = ReadTangent(readout, i, batch[i].start->x, tangents[i]);
  return results;
}

std::vector<LossGradient> DifferentiateLosses(Backend& backend, std::span<const RolloutInput> batch,
                                              const RolloutOptions& options,
                                              const ReadoutLoss& loss) {
  loss.Check(batch.size());
  std::vector<Recording> recordings;
  const std::vector<RolloutResult> ends = backend.Rollouts(batch, options, &recordings);
  std::vector<LossGradient> results(batch.size());
  std::vector<RowMatrix> dL_dx(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(backend.threads())
  for (std::size_t i = 0; i < batch.size(); ++i) {
    results[i].status = ends[i].status;
    if (ends[i].status == RolloutStatus::kOk)
      results[i].loss = EvaluateLoss(loss, i, ends[i].end.x, &dL_dx[i]);
  }
  AddGradients(backend, batch, options, &recordings, &dL_dx, &results);
  return results;
}

}  // namespace drape
