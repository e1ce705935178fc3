// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/outline_residuals.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/util/errors.h"

namespace drape {

std::optional<double> OutlineRms(const Mesh& mesh, const Eigen::VectorXd& x,
                                 const Observation& observation) {
  Outline outline;
  if (!OutlineFromMesh(mesh, x, observation.outline_camera(),
                       static_cast<int>(observation.radius.size()), &outline))
    return std::nullopt;
  return ProfileRms(outline.radius, observation.radius);
}

RolloutCounts& RolloutCounts::operator+=(const RolloutCounts& other) {
  rollouts += other.rollouts;
  tangents += other.tangents;
  failed += other.failed;
  jumps += other.jumps;
  capped += other.capped;
  return *this;
}

OutlineResiduals::OutlineResiduals(Backend* backend, const MaterialParametrisation* parametrisation,
                                   const std::vector<Observation>* observations,
                                   std::vector<State> starts, const OutlineResidualOptions& options)
    : backend_(backend),
      parametrisation_(parametrisation),
      observations_(observations),
      starts_(std::move(starts)),
      options_(options),
      theta_(Eigen::VectorXd::Zero(parametrisation->size())),
      evaluations_(observations->size()) {
  CHECK(!observations->empty());
  CHECK_EQ(observations->size(), starts_.size());
  CHECK(by_tangents() || options.solve_mode == SolveMode::kStatic);
  for (const Observation& observation : *observations)
    CHECK_EQ(observation.radius.size(), num_angles());
}

void OutlineResiduals::PrepareForEvaluation(bool with_jacobians, bool) {
  // Ceres differentiates only where it has settled: the point of its last accepted trial.
  if (with_jacobians) {
    if (options_.warm_restart && EvaluatedHere()) RestartFromLastShapes();
    Evaluate(true);
    Accept();
  } else if (IsTooFar()) {
    evaluated_theta_ = theta_;
    evaluations_.assign(num_observations(), Evaluation());
    ++counts_.capped;
  } else if (!EvaluatedHere()) {
    Evaluate(false);
  }
}

bool OutlineResiduals::IsTooFar() const {
  if (!has_accepted()) return false;
  const Eigen::VectorXd change = accepted_.jacobian * (theta_ - accepted_.theta);
  return options_.sigma_px * change.norm() >
         options_.max_outline_change * std::sqrt(static_cast<double>(change.size()));
}

bool OutlineResiduals::EvaluatedHere() const {
  return evaluated_theta_.size() == theta_.size() && evaluated_theta_ == theta_;
}

void OutlineResiduals::RestartFromLastShapes() {
  for (int i = 0; i < num_observations(); ++i)
    if (evaluations_[i].valid)
      starts_[i] = {evaluations_[i].x, Eigen::VectorXd::Zero(evaluations_[i].x.size())};
}

void OutlineResiduals::Evaluate(bool with_jacobians) {
  const MaterialField material = parametrisation_->Material(theta_);
  evaluated_theta_ = theta_;
  evaluations_.assign(num_observations(), Evaluation());
  if (!with_jacobians) PredictShapes();
  if (options_.solve_mode == SolveMode::kDynamic) {
    RunDynamic(material, with_jacobians);
  } else {
    RunStatic(material, with_jacobians);
  }
  counts_.rollouts += num_observations();
  if (with_jacobians) counts_.tangents += num_observations();
  for (int i = 0; i < num_observations(); ++i) {
    if (!evaluations_[i].valid) {
      ++counts_.failed;
    } else if (!with_jacobians && LeftBranch(i)) {
      evaluations_[i].valid = false;
      ++counts_.jumps;
    } else {
      FillResidual(i, with_jacobians);
    }
  }
}

void OutlineResiduals::RunDynamic(const MaterialField& material, bool with_jacobians) {
  const std::vector<RolloutInput> inputs = MakeInputs(material, starts_);
  if (with_jacobians) {
    const std::vector<const MaterialField*> weights(inputs.size(), &material);
    const Eigen::MatrixXd by_theta = parametrisation_->LogEntriesByTheta(theta_);
    std::vector<TangentResult> results = backend_->Tangents(inputs, weights, options_.rollout);
    for (int i = 0; i < num_observations(); ++i) {
      TangentResult& result = results[i];
      evaluations_[i].valid = result.rollout.status == RolloutStatus::kOk;
      evaluations_[i].x = std::move(result.rollout.end.x);
      if (evaluations_[i].valid) evaluations_[i].x_by_theta = result.dx * by_theta;
    }
  } else {
    std::vector<RolloutResult> results = backend_->Rollouts(inputs, options_.rollout, nullptr);
    for (int i = 0; i < num_observations(); ++i)
      evaluations_[i] = {
          results[i].status == RolloutStatus::kOk, std::move(results[i].end.x), {}, {}, {}};
  }
}

void OutlineResiduals::RunStatic(const MaterialField& material, bool with_jacobians) {
  std::vector<State> starts(num_observations());
  for (int i = 0; i < num_observations(); ++i)
    starts[i].x = with_jacobians || !has_accepted()
                      ? starts_[i].x
                      : ReachSafely(backend_->model(), accepted_.x[i], predicted_x_[i]);
  std::vector<EquilibriumResult> results =
      backend_->Equilibria(MakeInputs(material, starts), options_.equilibrium);
  for (int i = 0; i < num_observations(); ++i) {
    evaluations_[i].valid = results[i].status == EquilibriumStatus::kStable;
    evaluations_[i].x = starts[i].x = std::move(results[i].x);
  }
  if (!with_jacobians) return;
  if (by_tangents()) {
    FindTangents(material, starts);
  } else {
    FindAdjoints(material, starts);
  }
}

void OutlineResiduals::FindTangents(const MaterialField& material,
                                    const std::vector<State>& drapes) {
  const std::vector<const MaterialField*> weights(drapes.size(), &material);
  const Eigen::MatrixXd by_theta = parametrisation_->LogEntriesByTheta(theta_);
  const std::vector<RowMatrix> tangents =
      backend_->EquilibriumTangents(MakeInputs(material, drapes), weights);
  for (int i = 0; i < num_observations(); ++i) {
    evaluations_[i].valid &= tangents[i].size() > 0;
    if (tangents[i].size() > 0) evaluations_[i].x_by_theta = tangents[i] * by_theta;
  }
}

void OutlineResiduals::FindAdjoints(const MaterialField& material,
                                    const std::vector<State>& drapes) {
  std::vector<RowMatrix> seeds(drapes.size());
  for (int i = 0; i < num_observations(); ++i) {
    Outline outline;
    evaluations_[i].valid &= ReadOutline(i, &outline);
    seeds[i] = OutlineAdjointSeeds(outline, backend_->model().mesh.num_vertices());
  }
  const auto gradients = backend_->EquilibriumAdjoints(MakeInputs(material, drapes), seeds);
  for (int i = 0; i < num_observations(); ++i) {
    evaluations_[i].valid &= gradients[i].has_value();
    if (evaluations_[i].valid)
      evaluations_[i].jacobian =
          parametrisation_->Vjp(material, *gradients[i]).transpose() / options_.sigma_px;
  }
}

void OutlineResiduals::PredictShapes() {
  predicted_x_ = accepted_.x;
  if (!has_accepted()) return;
  const Eigen::VectorXd change = theta_ - accepted_.theta;
  if (by_tangents()) {
    for (int i = 0; i < num_observations(); ++i)
      predicted_x_[i] += accepted_.shape_by_theta[i] * change;
    return;
  }
  const MaterialField material = parametrisation_->Material(accepted_.theta);
  const MaterialField direction = parametrisation_->Jvp(material, change);
  std::vector<State> drapes(num_observations());
  for (int i = 0; i < num_observations(); ++i) drapes[i].x = accepted_.x[i];
  const std::vector<const MaterialField*> changes(drapes.size(), &direction);
  const auto moves = backend_->EquilibriumJvp(MakeInputs(material, drapes), changes);
  for (int i = 0; i < num_observations(); ++i)
    if (moves[i].size() > 0) predicted_x_[i] += moves[i];
}

bool OutlineResiduals::LeftBranch(int i) const {
  return has_accepted() &&
         (evaluations_[i].x - predicted_x_[i]).cwiseAbs().maxCoeff() > options_.max_jump;
}

bool OutlineResiduals::ReadOutline(int i, Outline* outline) const {
  return OutlineFromMesh(backend_->model().mesh, evaluations_[i].x,
                         (*observations_)[i].outline_camera(), num_angles(), outline);
}

void OutlineResiduals::FillResidual(int i, bool with_jacobian) {
  Evaluation& evaluation = evaluations_[i];
  Outline outline;
  evaluation.valid = ReadOutline(i, &outline);
  if (!evaluation.valid) {
    ++counts_.failed;
    return;
  }
  evaluation.residual = (outline.radius - (*observations_)[i].radius) / options_.sigma_px;
  if (with_jacobian && by_tangents())
    evaluation.jacobian = OutlineJacobianTimes(outline, evaluation.x_by_theta) / options_.sigma_px;
}

bool OutlineResiduals::all_valid() const {
  return std::all_of(evaluations_.begin(), evaluations_.end(),
                     [](const Evaluation& each) { return each.valid; });
}

void OutlineResiduals::Accept() {
  if (!all_valid()) return;
  accepted_.theta = theta_;
  accepted_.x.resize(num_observations());
  accepted_.shape_by_theta.resize(num_observations());
  accepted_.residual.resize(num_observations() * num_angles());
  accepted_.jacobian.resize(num_observations() * num_angles(), num_parameters());
  for (int i = 0; i < num_observations(); ++i) {
    Evaluation& evaluation = evaluations_[i];
    accepted_.x[i] = evaluation.x;
    accepted_.shape_by_theta[i] = std::exchange(evaluation.x_by_theta, {});
    accepted_.residual.segment(i * num_angles(), num_angles()) = evaluation.residual;
    accepted_.jacobian.middleRows(i * num_angles(), num_angles()) = evaluation.jacobian;
  }
}

void OutlineResiduals::StartFromAccepted() {
  for (int i = 0; has_accepted() && i < num_observations(); ++i)
    starts_[i] = {accepted_.x[i], Eigen::VectorXd::Zero(accepted_.x[i].size())};
}

void OutlineResiduals::Restore(Point point) {
  accepted_ = std::move(point);
  evaluated_theta_.resize(0);
  StartFromAccepted();
}

bool OutlineResiduals::Residuals(int i, double* residuals) const {
  const Evaluation& evaluation = evaluations_[i];
  if (!evaluation.valid) return false;
  std::copy_n(evaluation.residual.data(), evaluation.residual.size(), residuals);
  return true;
}

void OutlineResiduals::CopyJacobian(int i, int first, int count, double* jacobian) const {
  Eigen::Map<RowMatrix>(jacobian, num_angles(), count) =
      evaluations_[i].jacobian.middleCols(first, count);
}

}  // namespace drape
