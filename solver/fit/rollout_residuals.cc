// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/rollout_residuals.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "cuda/make_backend.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/dynamics.h"

namespace drape {

RolloutCounts& RolloutCounts::operator+=(const RolloutCounts& other) {
  rollouts += other.rollouts;
  tangents += other.tangents;
  failed += other.failed;
  jumps += other.jumps;
  capped += other.capped;
  return *this;
}

RolloutOptions WithFinerSteps(RolloutOptions options, int parts) {
  options.h /= parts;
  options.steps *= parts;
  for (int& frame : options.frames) frame *= parts;
  return options;
}

RolloutBlock::Run OwnRun(std::shared_ptr<const ClothModel> model, State start,
                         const std::string& backend) {
  const std::shared_ptr<Backend> owned = MakeBackend(backend, model, 1);
  return {
      .backend = owned.get(), .start = std::move(start), .owned = owned, .model = std::move(model)};
}

int RolloutBlock::num_residuals() const {
  int sum = 0;
  for (const Sight& sight : sights) sum += static_cast<int>(sight.data.size());
  return sum;
}

std::vector<RolloutBlock> MakeBlocks(Backend* backend, const std::vector<Observation>& observations,
                                     const std::vector<State>& starts,
                                     const ResidualOptions& options) {
  CHECK_EQ(observations.size(), starts.size());
  std::vector<RolloutBlock> blocks;
  for (std::size_t i = 0; i < observations.size(); ++i)
    blocks.push_back(
        {.runs = {{.backend = backend, .start = starts[i]}},
         .sights = MakeSights(*observations[i].Measured(options.sigma_px), backend->model()),
         .solve_mode = options.solve_mode,
         .rollout = options.rollout,
         .equilibrium = options.equilibrium});
  return blocks;
}

RolloutResiduals ObservationResiduals(Backend* backend,
                                      const MaterialParametrisation* parametrisation,
                                      const std::vector<Observation>& observations,
                                      const std::vector<State>& starts,
                                      const ResidualOptions& options) {
  return {parametrisation, MakeBlocks(backend, observations, starts, options), options};
}

int RolloutBlock::num_independent() const {
  int sum = 0;
  for (const Sight& sight : sights)
    sum += sight.num_telling > 0 ? CountIndependent(sight) : static_cast<int>(sight.data.size());
  return sum;
}

RolloutResiduals::RolloutResiduals(const MaterialParametrisation* parametrisation,
                                   std::vector<RolloutBlock> blocks, const ResidualOptions& options)
    : parametrisation_(parametrisation),
      blocks_(std::move(blocks)),
      first_row_(1, 0),
      options_(options),
      theta_(Eigen::VectorXd::Zero(parametrisation->size())) {
  CHECK(!blocks_.empty());
  const Eigen::MatrixXd by_theta = parametrisation->DynamicsByTheta(theta_);
  frees_density_ = by_theta.size() > 0 && !by_theta.row(kByDensity).isZero(0.0);
  for (const RolloutBlock& block : blocks_) {
    CHECK(parametrisation->has_one_table() || block.solve_mode == SolveMode::kStatic);
    CHECK(block.is_unique || !block.prepare) << "a branch is predicted under the fabric itself";
    for (const Sight& sight : block.sights) CHECK_EQ(sight.readouts.size(), block.runs.size());
    first_row_.push_back(first_row_.back() + block.num_residuals());
  }
  ClearEvaluations();
}

void RolloutResiduals::Rebind(Backend* backend) {
  for (RolloutBlock& block : blocks_)
    for (RolloutBlock::Run& run : block.runs)
      if (run.owned == nullptr) run.backend = backend;
}

void RolloutResiduals::RenewOwnBackends() {
  for (RolloutBlock& block : blocks_)
    for (RolloutBlock::Run& run : block.runs)
      if (run.owned != nullptr) {
        run.owned = MakeBackend(run.owned->name(), run.model, 1);
        run.backend = run.owned.get();
      }
}

bool RolloutResiduals::by_tangents(int block) const {
  return parametrisation_->has_one_table() &&
         (blocks_[block].solve_mode == SolveMode::kDynamic || frees_density_ ||
          2 * blocks_[block].num_residuals() >= kMaterialEntries);
}

Eigen::MatrixXd RolloutResiduals::NumbersByTheta(int block) const {
  const Eigen::MatrixXd more = parametrisation_->DynamicsByTheta(theta_);
  Eigen::MatrixXd by_theta =
      Eigen::MatrixXd::Zero(kMaterialEntries + kDynamicsEntries + 3, num_parameters());
  by_theta.topRows<kMaterialEntries>() = parametrisation_->LogEntriesByTheta(theta_);
  if (more.size() > 0) by_theta.bottomRows<kDynamicsEntries + 3>() = more;
  // A block is of the fabric's density, or of another in proportion to it.
  by_theta.row(kMaterialEntries + kByDensity) *= material(block).density / fabric_.density;
  return by_theta;
}

void RolloutResiduals::PrepareForEvaluation(bool with_jacobians, bool) {
  // Ceres differentiates only where it has settled: the point of its last accepted trial.
  if (with_jacobians) {
    if (EvaluatedHere()) RestartFromLastShapes();
    Evaluate(true);
    Accept();
  } else if (IsTooFar()) {
    evaluated_theta_ = theta_;
    ClearEvaluations();
    ++counts_.capped;
  } else if (!EvaluatedHere()) {
    Evaluate(false);
  }
}

bool RolloutResiduals::IsTooFar() const {
  if (!has_accepted()) return false;
  const Eigen::VectorXd change = accepted_.jacobian * (theta_ - accepted_.theta);
  double squares = 0.0;
  int rows = 0;
  for (int i = 0; i < num_blocks(); ++i) {
    if (blocks_[i].is_unique) continue;
    squares += change.segment(first_row_[i], blocks_[i].num_residuals()).squaredNorm();
    rows += blocks_[i].num_residuals();
  }
  return options_.sigma_px * std::sqrt(squares) > options_.max_outline_change * std::sqrt(rows);
}

bool RolloutResiduals::EvaluatedHere() const {
  return evaluated_theta_.size() == theta_.size() && evaluated_theta_ == theta_;
}

// After an accepted step the next rollouts start from its drapes, so that a fit by time steps
// converges to an equilibrium on one branch instead of chasing a transient [METHODS, P22].
void RolloutResiduals::RestartFromLastShapes() {
  for (int i = 0; i < num_blocks(); ++i)
    for (std::size_t k = 0; !is_motion(i) && evaluations_[i].valid && k < blocks_[i].runs.size();
         ++k)
      blocks_[i].runs[k].start = AtRest({evaluations_[i].runs[k].x}).front();
}

void RolloutResiduals::ClearEvaluations() {
  evaluations_.assign(blocks_.size(), {});
  for (int i = 0; i < num_blocks(); ++i) evaluations_[i].runs.resize(blocks_[i].runs.size());
}

std::vector<RolloutResiduals::Batch> RolloutResiduals::ListBatches() const {
  std::vector<Batch> batches;
  for (int i = 0; i < num_blocks(); ++i)
    for (int k = 0; k < static_cast<int>(blocks_[i].runs.size()); ++k) {
      const auto same = [&](const Batch& batch) {
        return run(batch.front()).backend == blocks_[i].runs[k].backend;
      };
      const auto found = std::find_if(batches.begin(), batches.end(), same);
      if (found == batches.end())
        batches.push_back({{i, k}});
      else
        found->push_back({i, k});
    }
  return batches;
}

void RolloutResiduals::Evaluate(bool with_jacobians) {
  fabric_ = parametrisation_->Material(theta_);
  prepared_.resize(blocks_.size());
  for (int i = 0; i < num_blocks(); ++i)
    if (blocks_[i].prepare) prepared_[i] = blocks_[i].prepare(fabric_);
  evaluated_theta_ = theta_;
  ClearEvaluations();
  const std::vector<Batch> batches = ListBatches();
  if (!with_jacobians) PredictShapes(batches);
  for (const Batch& batch : batches) {
    if (blocks_[batch.front().block].solve_mode == SolveMode::kDynamic) {
      RunDynamic(batch, with_jacobians);
    } else {
      RunStatic(batch, with_jacobians);
    }
    counts_.rollouts += static_cast<int>(batch.size());
    if (with_jacobians) counts_.tangents += static_cast<int>(batch.size());
  }
  for (int i = 0; i < num_blocks(); ++i) {
    Evaluation& evaluation = evaluations_[i];
    evaluation.valid = std::all_of(evaluation.runs.begin(), evaluation.runs.end(),
                                   [](const RunResult& each) { return each.found; });
    if (!evaluation.valid) {
      ++counts_.failed;
    } else if (!with_jacobians && LeftBranch(i)) {
      evaluation.valid = false;
      ++counts_.jumps;
    } else {
      FillResidual(i, with_jacobians);
    }
  }
}

std::vector<RolloutInput> RolloutResiduals::MakeInputs(const Batch& batch,
                                                       const std::vector<State>& starts) const {
  std::vector<RolloutInput> inputs;
  for (std::size_t k = 0; k < batch.size(); ++k)
    inputs.push_back({&material(batch[k].block), &starts[k]});
  return inputs;
}

RolloutResiduals::RunResult RolloutResiduals::TakeRollout(RolloutResult rollout) {
  RunResult taken{rollout.status == RolloutStatus::kOk, std::move(rollout.end.x), {}};
  for (State& frame : rollout.frames) taken.frames.push_back(std::move(frame.x));
  return taken;
}

void RolloutResiduals::RunDynamic(const Batch& batch, bool with_jacobians) {
  Backend& backend = *run(batch.front()).backend;
  const RolloutOptions options =
      WithFinerSteps(blocks_[batch.front().block].rollout, run(batch.front()).finer);
  std::vector<State> starts;
  const Eigen::Vector3d velocity = parametrisation_->StartVelocity(theta_);
  for (const Place& place : batch) {
    starts.push_back(run(place).start);
    if (is_motion(place.block))
      starts.back().v += velocity.replicate(starts.back().v.size() / 3, 1);
  }
  std::vector<RolloutInput> inputs = MakeInputs(batch, starts);
  if (with_jacobians) {
    std::vector<const MaterialField*> weights;
    for (const Place& place : batch) weights.push_back(&material(place.block));
    const Eigen::MatrixXd all = NumbersByTheta(batch.front().block);
    TangentOptions more{.dynamics = !all.bottomRows<kDynamicsEntries + 3>().isZero(0.0)};
    if (!all.bottomRows<3>().isZero(0.0))
      more.start_dv = Eigen::Matrix3d::Identity().replicate(backend.model().mesh.num_vertices(), 1);
    for (RolloutInput& input : inputs) input.tangent = &more;
    std::vector<TangentResult> results = backend.Tangents(inputs, weights, options);
    for (std::size_t k = 0; k < batch.size(); ++k) {
      RolloutResult& rollout = results[k].rollout;
      RunResult& own = result(batch[k]);
      own = TakeRollout(std::move(rollout));
      if (!own.found) continue;
      const Eigen::MatrixXd by_theta = all.topRows(results[k].dx.cols());
      own.x_by_theta = results[k].dx * by_theta;
      for (FrameTangent& frame : results[k].frames)
        own.frames_by_theta.push_back(std::exchange(frame, {}).dx * by_theta);
    }
  } else {
    std::vector<RolloutResult> results = backend.Rollouts(inputs, options, nullptr);
    for (std::size_t k = 0; k < batch.size(); ++k)
      result(batch[k]) = TakeRollout(std::move(results[k]));
  }
}

State RolloutResiduals::StaticStart(const Place& place, bool with_jacobians) const {
  const State& start = run(place).start;
  if (start.x.size() == 0 && !has_accepted() && blocks_[place.block].starts_like_previous)
    return StartLikePrevious(place);
  if (with_jacobians || !has_accepted()) return start;
  const Eigen::VectorXd& accepted = accepted_.x[place.block][place.run];
  if (blocks_[place.block].is_unique) return AtRest({accepted}).front();
  return {ReachSafely(run(place).backend->model(), accepted, predicted_x_[place.block][place.run]),
          {}};
}

State RolloutResiduals::StartLikePrevious(const Place& place) const {
  const RunResult& previous = evaluations_[place.block - 1].runs[place.run];
  if (!previous.found) return {};
  const auto size = [&](int block) {
    return blocks_[block].runs[place.run].backend->model().mesh.rest_x.maxCoeff();
  };
  return {previous.x * (size(place.block) / size(place.block - 1)), {}};
}

void RolloutResiduals::RunStatic(const Batch& batch, bool with_jacobians) {
  Backend& backend = *run(batch.front()).backend;
  const EquilibriumOptions& options = blocks_[batch.front().block].equilibrium;
  std::vector<State> drapes;
  Batch by_newton;
  for (const Place& place : batch)
    if (State start = StaticStart(place, with_jacobians); start.x.size() > 0) {
      by_newton.push_back(place);
      drapes.push_back(std::move(start));
    }
  if (!by_newton.empty()) {
    std::vector<EquilibriumResult> results =
        backend.Equilibria(MakeInputs(by_newton, drapes), options);
    for (std::size_t k = 0; k < by_newton.size(); ++k)
      result(by_newton[k]) = {
          results[k].status == EquilibriumStatus::kStable, std::move(results[k].x), {}};
  }
  for (const Place& place : batch) {
    if (result(place).found || !blocks_[place.block].is_unique) continue;
    EquilibriumResult rest = SolveFromRest(backend, material(place.block), options);
    result(place) = {rest.status == EquilibriumStatus::kStable, std::move(rest.x), {}};
  }
  if (with_jacobians) FindDerivatives(batch);
}

void RolloutResiduals::FindDerivatives(const Batch& batch) {
  Batch tangents, adjoints;
  for (const Place& place : batch) {
    if (by_tangents(place.block))
      tangents.push_back(place);
    else if (result(place).found)
      adjoints.push_back(place);
  }
  if (!tangents.empty()) FindTangents(tangents);
  if (!adjoints.empty()) FindAdjoints(adjoints);
}

void RolloutResiduals::FindTangents(const Batch& batch) {
  const std::vector<State> drapes = ListDrapes(batch);
  std::vector<const MaterialField*> weights;
  for (const Place& place : batch) weights.push_back(&material(place.block));
  const TangentOptions more{.dynamics = frees_density_};
  std::vector<RolloutInput> inputs = MakeInputs(batch, drapes);
  for (RolloutInput& input : inputs) input.tangent = &more;
  std::vector<RowMatrix> tangents =
      run(batch.front()).backend->EquilibriumTangents(inputs, weights);
  for (std::size_t k = 0; k < batch.size(); ++k) {
    result(batch[k]).found &= tangents[k].size() > 0;
    if (tangents[k].size() == 0) continue;
    if (blocks_[batch[k].block].has_own_bend)
      tangents[k].middleCols<kBendEntries>(kStretchEntries).setZero();
    result(batch[k]).x_by_theta =
        tangents[k] * NumbersByTheta(batch[k].block).topRows(tangents[k].cols());
  }
}

std::vector<State> RolloutResiduals::ListDrapes(const Batch& batch) const {
  std::vector<State> drapes(batch.size());
  for (std::size_t k = 0; k < batch.size(); ++k)
    drapes[k].x = evaluations_[batch[k].block].runs[batch[k].run].x;
  return drapes;
}

std::optional<RowMatrix> RolloutResiduals::AdjointSeeds(const Place& place) const {
  const RolloutBlock& block = blocks_[place.block];
  const Eigen::VectorXd& x = evaluations_[place.block].runs[place.run].x;
  RowMatrix seeds(x.size(), block.num_residuals());
  int row = 0;
  for (const Sight& sight : block.sights) {
    Eigen::VectorXd r;
    ReadoutJacobian dr_dx;
    if (!sight.readouts[place.run]->ReadCloth(material(place.block), x, &r, &dr_dx, nullptr))
      return std::nullopt;
    const auto rows = static_cast<int>(r.size());
    seeds.middleCols(row, rows) =
        RowMatrix(dr_dx).transpose() / (sight.sigma / block.runs[place.run].weight);
    row += rows;
  }
  return seeds;
}

void RolloutResiduals::FindAdjoints(const Batch& batch) {
  Batch read;
  std::vector<RowMatrix> seeds;
  for (const Place& place : batch) {
    std::optional<RowMatrix> own = AdjointSeeds(place);
    result(place).found = own.has_value();
    if (!own) continue;
    read.push_back(place);
    seeds.push_back(std::move(*own));
  }
  const std::vector<State> drapes = ListDrapes(read);
  const auto gradients =
      run(batch.front()).backend->EquilibriumAdjoints(MakeInputs(read, drapes), seeds);
  for (std::size_t k = 0; k < read.size(); ++k) {
    result(read[k]).found = gradients[k].has_value();
    if (gradients[k]) AddAdjoint(read[k].block, *gradients[k]);
  }
}

void RolloutResiduals::AddAdjoint(int block, const MaterialGradient& gradient) {
  RowMatrix& jacobian = evaluations_[block].jacobian;
  if (jacobian.size() == 0) jacobian.setZero(blocks_[block].num_residuals(), num_parameters());
  if (!parametrisation_->has_one_table()) {
    jacobian += parametrisation_->Vjp(material(block), gradient).transpose();
    return;
  }
  RowMatrix by_log_entry = gradient.Contract(material(block));
  if (blocks_[block].has_own_bend) by_log_entry.bottomRows(kBendEntries).setZero();
  jacobian += by_log_entry.transpose() * parametrisation_->LogEntriesByTheta(theta_);
}

void RolloutResiduals::PredictShapes(const std::vector<Batch>& batches) {
  predicted_x_ = accepted_.x;
  if (!has_accepted()) return;
  const Eigen::VectorXd change = theta_ - accepted_.theta;
  for (int i = 0; i < num_blocks(); ++i)
    for (std::size_t k = 0; by_tangents(i) && k < predicted_x_[i].size(); ++k)
      predicted_x_[i][k] += accepted_.x_by_theta[i][k] * change;
  const MaterialField material = parametrisation_->Material(accepted_.theta);
  const MaterialField direction = parametrisation_->Jvp(material, change);
  for (Batch batch : batches) {
    std::erase_if(batch, [&](const Place& place) {
      return by_tangents(place.block) || blocks_[place.block].is_unique;
    });
    if (!batch.empty()) PredictByProducts(batch, material, direction);
  }
}

void RolloutResiduals::PredictByProducts(const Batch& batch, const MaterialField& accepted,
                                         const MaterialField& direction) {
  std::vector<State> drapes(batch.size());
  std::vector<RolloutInput> inputs;
  for (std::size_t k = 0; k < batch.size(); ++k) {
    drapes[k].x = accepted_.x[batch[k].block][batch[k].run];
    inputs.push_back({&accepted, &drapes[k]});
  }
  const std::vector<const MaterialField*> changes(batch.size(), &direction);
  const auto moves = run(batch.front()).backend->EquilibriumJvp(inputs, changes);
  for (std::size_t k = 0; k < batch.size(); ++k)
    if (moves[k].size() > 0) predicted_x_[batch[k].block][batch[k].run] += moves[k];
}

bool RolloutResiduals::LeftBranch(int block) const {
  if (!has_accepted() || blocks_[block].is_unique) return false;
  for (std::size_t k = 0; k < predicted_x_[block].size(); ++k)
    if ((evaluations_[block].runs[k].x - predicted_x_[block][k]).cwiseAbs().maxCoeff() >
        options_.max_jump)
      return true;
  return false;
}

void RolloutResiduals::FillResidual(int block, bool with_jacobian) {
  const bool by_x = with_jacobian && by_tangents(block);
  Evaluation& evaluation = evaluations_[block];
  const RolloutBlock& own = blocks_[block];
  evaluation.residual.resize(own.num_residuals());
  if (by_x) evaluation.jacobian.setZero(own.num_residuals(), num_parameters());
  int row = 0;
  for (const Sight& sight : own.sights) {
    const auto rows = static_cast<int>(sight.data.size());
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows);
    for (std::size_t k = 0; k < own.runs.size(); ++k) {
      Eigen::VectorXd r;
      ReadoutJacobian dr_dx;
      const RunResult& run = evaluation.runs[k];
      MaterialJacobian dr_dp;
      evaluation.valid &= sight.readouts[k]->ReadCloth(
          material(block), sight.frame < 0 ? run.x : run.frames[sight.frame], &r,
          by_x ? &dr_dx : nullptr, with_jacobian ? &dr_dp : nullptr);
      if (!evaluation.valid) {
        ++counts_.failed;
        return;
      }
      const double weight = own.runs[k].weight, scale = sight.sigma / weight;
      sum += weight * r;
      if (dr_dp.size() > 0)
        evaluation.jacobian.middleRows(row, rows) +=
            dr_dp * NumbersByTheta(block).topRows(dr_dp.cols()) / scale;
      if (by_x)
        evaluation.jacobian.middleRows(row, rows) +=
            (dr_dx * (sight.frame < 0 ? run.x_by_theta : run.frames_by_theta[sight.frame])) / scale;
    }
    evaluation.residual.segment(row, rows) = (sum - sight.data) / sight.sigma;
    row += rows;
  }
}

bool RolloutResiduals::all_valid() const {
  return std::all_of(evaluations_.begin(), evaluations_.end(),
                     [](const Evaluation& each) { return each.valid; });
}

double RolloutResiduals::cost(int block) const {
  Eigen::VectorXd residual = evaluations_[block].residual;
  return Weigh(block, residual, nullptr);
}

double RolloutResiduals::Weigh(int block, Eigen::Ref<Eigen::VectorXd> residual,
                               Eigen::Ref<Eigen::MatrixXd>* jacobian) const {
  double cost = 0.0;
  Eigen::Index row = 0;
  for (const Sight& sight : blocks_[block].sights) {
    const Eigen::Index rows = sight.data.size();
    if (jacobian != nullptr) {
      Eigen::Ref<Eigen::MatrixXd> own = jacobian->middleRows(row, rows);
      cost += WeighByLoss(sight, residual.segment(row, rows), &own);
    } else {
      cost += WeighByLoss(sight, residual.segment(row, rows), nullptr);
    }
    row += rows;
  }
  return cost;
}

void RolloutResiduals::Accept() {
  if (!all_valid()) return;
  accepted_.theta = theta_;
  accepted_.x.assign(blocks_.size(), {});
  accepted_.x_by_theta.assign(blocks_.size(), {});
  accepted_.residual.resize(num_residuals());
  accepted_.jacobian.resize(num_residuals(), num_parameters());
  accepted_.cost = 0.0;
  for (int i = 0; i < num_blocks(); ++i) {
    Evaluation& evaluation = evaluations_[i];
    for (RunResult& each : evaluation.runs) {
      accepted_.x[i].push_back(each.x);
      accepted_.x_by_theta[i].push_back(std::exchange(each.x_by_theta, {}));
    }
    const Eigen::Index rows = evaluation.residual.size();
    Eigen::Ref<Eigen::MatrixXd> jacobian = accepted_.jacobian.middleRows(first_row_[i], rows);
    jacobian = evaluation.jacobian;
    accepted_.residual.segment(first_row_[i], rows) = evaluation.residual;
    accepted_.cost += Weigh(i, accepted_.residual.segment(first_row_[i], rows), &jacobian);
  }
}

std::vector<State> RolloutResiduals::starts() const {
  std::vector<State> starts;
  for (const RolloutBlock& block : blocks_) starts.push_back(block.runs.front().start);
  return starts;
}

void RolloutResiduals::StartFromAccepted() {
  for (std::size_t i = 0; i < accepted_.x.size(); ++i)
    for (std::size_t k = 0; !is_motion(static_cast<int>(i)) && k < accepted_.x[i].size(); ++k)
      blocks_[i].runs[k].start = AtRest({accepted_.x[i][k]}).front();
}

void RolloutResiduals::Restore(Point point) {
  accepted_ = std::move(point);
  evaluated_theta_.resize(0);
  StartFromAccepted();
}

}  // namespace drape
