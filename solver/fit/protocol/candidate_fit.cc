// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/candidate_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"

namespace drape {
namespace {

// A seed replaces a fitted drape when it comes this much nearer.
constexpr double kReseedGain = 0.97;
constexpr double kCostTolerance = 1e-3;  // of all rounds but the last

}  // namespace

void CandidateFitter::Log(CandidateTask& work, const char* format, auto... values) const {
  char line[256];
  const int place =
      std::snprintf(line, sizeof line, "round %d, branch %d: ", round_ + 1, work.index + 1);
  std::snprintf(line + place, sizeof line - place, format, values...);
  work.log.push_back(line);
}

// The drape of target i that grows from its seed under a material; empty when it is not stable.
Eigen::VectorXd CandidateFitter::SettledGuess(const MaterialField& material, int i, double lift,
                                              CandidateTask& work) const {
  SettleOptions settle = MakeSettleOptions(options_);
  settle.steps.cancel = settle.equilibrium.cancel = cancel_;
  ++work.counts.rollouts;
  const State seed = GuessState(fine_.model(), problem_.targets[i], lift);
  SettledDrape drape = std::move(Settle(fine_, material, {&seed, 1}, settle).front());
  if (drape.IsUsable(options_.integrator)) return std::move(drape.rest.x);
  if (drape.steps == RolloutStatus::kOk)
    Log(work, "a seed's drape is %s after %d Newton iterations (residual %.1e)",
        ToString(drape.rest.status), drape.rest.iterations, drape.rest.residual);
  return {};
}

// Root mean square distance of a drape from its outline [px]; negative when it has none.
double CandidateFitter::ComputeProfileRms(int i, const Eigen::VectorXd& x) const {
  const Observation& target = problem_.targets[i];
  Outline outline;
  if (x.size() == 0 ||
      !OutlineFromMesh(fine_.model().mesh, x, target.camera, options_.angles, &outline)) {
    return -1.0;
  }
  return ProfileRms(outline.radius, target.radius);
}

void CandidateFitter::Seed(CandidateTask& work) const {
  FitCandidate& branch = work.branch;
  branch.theta = Eigen::VectorXd::Zero(Parametrisation(branch).size());
  const MaterialField material = Scaled(problem_.material, branch.seed.stretch, branch.seed.bend);
  std::vector<Eigen::VectorXd> shapes;
  double sum = 0.0;
  for (int i = 0; i < int(problem_.targets.size()); ++i) {
    shapes.push_back(SettledGuess(material, i, branch.seed.lifts[i], work));
    const double rms = ComputeProfileRms(i, shapes.back());
    if (rms < 0.0) return;
    sum += rms * rms;
  }
  branch.seed_rms = std::sqrt(sum / double(shapes.size()));
  branch.shapes = std::move(shapes);
}

void CandidateFitter::Reseed(CandidateTask& work) const {
  FitCandidate& branch = work.branch;
  const MaterialField material = FittedMaterial(problem_, options_, branch);
  for (int i = 0; i < int(problem_.targets.size()); ++i) {
    double best = ComputeProfileRms(i, branch.shapes[i]);
    for (const double lift : options_.grid.lifts) {
      if (Cancelled()) return;
      Eigen::VectorXd x = SettledGuess(material, i, lift, work);
      const double rms = ComputeProfileRms(i, x);
      if (rms < 0.0 || rms > kReseedGain * best) continue;
      Log(work, "image %d seeded anew, lift %g: %.2f -> %.2f px", i + 1, lift, best, rms);
      best = rms;
      branch.shapes[i] = std::move(x);
    }
  }
}

void CandidateFitter::Fit(CandidateTask& work, const std::function<void(double)>& progress) const {
  const TableParametrisation parametrisation = Parametrisation(work.branch);
  std::vector<Observation> targets = WithStarts(work.branch);
  OutlineResiduals batch(&fine_, &parametrisation, &targets, MakeResidualOptions());
  const Eigen::VectorXd& theta = work.branch.theta;
  Eigen::Map<Eigen::VectorXd>(batch.theta(), theta.size()) = theta;
  FitOptions fit_options = MakeFitOptions();
  fit_options.progress = [&](const FitIteration& iteration) {
    progress(iteration.iteration / std::max(1.0, double(fit_options.max_iterations)));
  };
  std::optional<StripResiduals> tests = Tests();
  const FitSummary summary = drape::Fit(batch, fit_options, tests ? &*tests : nullptr);
  work.iterations += static_cast<int>(summary.iterations.size()) - 1;
  work.counts += summary.counts;
  if (summary.termination == FitTermination::kFailed) {
    work.branch.shapes.clear();
    Log(work, "failed, %s", summary.message.c_str());
  } else {
    Keep(summary, targets, work);
  }
}

void CandidateFitter::Keep(const FitSummary& summary, const std::vector<Observation>& targets,
                           CandidateTask& work) const {
  FitCandidate& branch = work.branch;
  branch.theta = summary.theta;
  branch.cost = summary.final_cost;
  branch.termination = summary.termination;
  branch.iterations += static_cast<int>(summary.iterations.size()) - 1;
  double sum = 0.0;
  for (int i = 0; i < int(targets.size()); ++i) {
    branch.shapes[i] = targets[i].start.x;
    sum += std::pow(ComputeProfileRms(i, branch.shapes[i]), 2);
  }
  branch.profile_rms = std::sqrt(sum / double(targets.size()));
  Log(work,
      "stretch %g, bend %g, lift %g, cost %.1f -> %.1f, %.2f px, %s, %d branch jumps, %d failed",
      branch.seed.stretch, branch.seed.bend, branch.seed.lifts.front(), summary.initial_cost,
      summary.final_cost, branch.profile_rms, ToString(summary.termination), summary.counts.jumps,
      summary.counts.failed);
}

Eigen::MatrixXd CandidateFitter::Jacobian(const FitCandidate& branch) const {
  const TableParametrisation parametrisation = Parametrisation(branch);
  std::vector<Observation> targets = WithStarts(branch);
  OutlineResiduals batch(&fine_, &parametrisation, &targets, MakeResidualOptions());
  Eigen::Map<Eigen::VectorXd>(batch.theta(), branch.theta.size()) = branch.theta;
  batch.PrepareForEvaluation(true, true);
  if (problem_.tests == nullptr || !batch.has_accepted()) return batch.accepted().jacobian;
  Eigen::VectorXd residual;
  RowMatrix of_tests;
  if (!Tests()->Evaluate(parametrisation, branch.theta, &residual, &of_tests)) return {};
  Eigen::MatrixXd jacobian(batch.accepted().jacobian.rows() + of_tests.rows(), of_tests.cols());
  jacobian << batch.accepted().jacobian, of_tests;
  return jacobian;
}

TableParametrisation CandidateFitter::Parametrisation(const FitCandidate& branch) const {
  return {Scaled(problem_.material, branch.seed.stretch, branch.seed.bend), options_.parameters};
}

std::vector<Observation> CandidateFitter::WithStarts(const FitCandidate& branch) const {
  std::vector<Observation> targets = problem_.targets;
  for (std::size_t i = 0; i < targets.size(); ++i)
    targets[i].start = {branch.shapes[i], Eigen::VectorXd::Zero(branch.shapes[i].size())};
  return targets;
}

std::optional<StripResiduals> CandidateFitter::Tests() const {
  return problem_.tests == nullptr ? std::nullopt : std::optional(problem_.tests->Clone());
}

OutlineResidualOptions CandidateFitter::MakeResidualOptions() const {
  OutlineResidualOptions batch;
  batch.integrator = options_.integrator;
  batch.equilibrium.max_iterations = options_.newton_iterations;
  batch.equilibrium.cancel = cancel_;
  batch.rollout.h = options_.settle_h;
  batch.rollout.steps = options_.settle_steps;
  batch.rollout.cancel = cancel_;
  batch.sigma_px = options_.sigma_px;
  batch.max_outline_change = options_.max_outline_change;
  batch.max_jump = options_.max_jump;
  batch.warm_restart = options_.warm_restart;
  return batch;
}

FitOptions CandidateFitter::MakeFitOptions() const {
  const bool last = round_ + 1 == static_cast<int>(options_.keep.size());
  FitOptions fit;
  fit.prior_sigma = options_.prior_sigma;
  fit.max_iterations = options_.iterations[round_];
  fit.initial_damping = options_.initial_damping;
  fit.cost_tolerance = last ? kLastCostTolerance : kCostTolerance;
  fit.cancel = cancel_;
  return fit;
}

}  // namespace drape
