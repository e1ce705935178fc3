// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/candidate_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/mesh/mesh.h"
#include "physics/util/text_format.h"
#include "solver/fit/protocol/guided_settle.h"
#include "solver/fit/protocol/initial_guess.h"

namespace drape {
namespace {

// A retried guess replaces a fitted drape when its misfit is lower by this factor.
constexpr double kRetryGain = 0.97;
// A drape that is pulled from a fitted one replaces it when its misfit is lower by this factor.
constexpr double kPullGain = 0.999;
// The shape after the time steps is taken to rest where its misfit is below this factor of the
// least: on its way to rest it hardly gets nearer.
constexpr double kRestFactor = 1.3;
constexpr double kRoundTolerance = 1e-3;  // of all rounds but the last
// TrustRegionOptions::least_scale of experiments, whose σ is their error: of a parameter that is
// determined to 10 %.
constexpr double kExperimentLeastScale = 1e2;
// A coarse mesh lets a fit drift to stretch stiffnesses under which a fine one has no drape: by how
// much they are lowered at a time, and at most.
constexpr double kSoftening = 1.0 / 8, kLeastSoftening = 1e-3;
constexpr double kNoDrape = std::numeric_limits<double>::infinity();

// The root mean square of at least one number.
double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / double(values.size()));
}

// ½ Σ residual², prior included; none where a drape or a further block cannot be computed.
std::optional<double> ComputeCost(const FitProblem& problem, const StagedFitOptions& options,
                                  const ClothModel& model, const FitCandidate& candidate) {
  double squares = (candidate.theta / options.prior_sigma).squaredNorm();
  const std::vector<Observation> observations = LaidObservations(problem, candidate);
  const MaterialField material = FittedMaterial(options, candidate);
  for (std::size_t i = 0; i < candidate.shapes.size(); ++i) {
    const auto measured = observations[i].Measured(options.residuals.sigma_px);
    const std::optional<double> misfit = Misfit(*measured, model, material, candidate.shapes[i]);
    if (!misfit) return std::nullopt;
    squares += CountResiduals(*measured, model) * *misfit * *misfit;
  }
  if (std::vector<RolloutBlock> further = FurtherBlocks(problem, nullptr); !further.empty()) {
    const TableParametrisation parametrisation(candidate.base, options.parameters);
    RolloutResiduals residuals(&parametrisation, std::move(further), options.residuals);
    Eigen::Map<Eigen::VectorXd>(residuals.theta(), candidate.theta.size()) = candidate.theta;
    residuals.PrepareForEvaluation(false, true);
    if (!residuals.all_valid()) return std::nullopt;
    for (int i = 0; i < residuals.num_blocks(); ++i) squares += 2.0 * residuals.cost(i);
  }
  return 0.5 * squares;
}

}  // namespace

void CandidateFitter::Log(CandidateTask& task, const char* format, auto... values) const {
  task.log.push_back(Format("round %d, candidate %d: ", round_ + 1, task.index + 1) +
                     Format(format, values...));
}

// The shape into which a start falls under a material, guided by its observation; empty where a
// time step fails.
Eigen::VectorXd CandidateFitter::Fall(const MaterialField& material, const Observation& observation,
                                      double lift, CandidateTask& task) const {
  SettleOptions steps = CancellableSettle();
  steps.solve_mode = SolveMode::kDynamic;
  ++task.counts.rollouts;
  SettledDrape end = SettleGuided(
      fine_, material, StartAt(*observation.Measured(), fine_.model(), lift), observation, steps);
  return end.IsUsable(steps.solve_mode) ? std::move(end.rest.x) : Eigen::VectorXd();
}

// The drape at rest near a shape; empty where it is not stable.
Eigen::VectorXd CandidateFitter::Rest(const MaterialField& material, Eigen::VectorXd x,
                                      CandidateTask& task) const {
  SettleOptions settle = CancellableSettle();
  if (settle.solve_mode == SolveMode::kDynamic || x.size() == 0) return x;
  settle.steps.steps = 0;
  const std::vector<State> starts = AtRest({std::move(x)});
  SettledDrape drape = std::move(Settle(fine_, material, starts, settle).front());
  if (drape.IsUsable(settle.solve_mode)) return std::move(drape.rest.x);
  Log(task, "the drape of an initial guess is %s after %d Newton iterations (residual %.1e)",
      ToString(drape.rest.status), drape.rest.iterations, drape.rest.residual);
  return {};
}

double CandidateFitter::SettleBest(const MaterialField& material, int i, double lift, double most,
                                   CandidateTask& task) const {
  task.candidate.mirrored.resize(problem_.observations.size());
  for (const bool mirrored : {false, true}) {
    if (Cancelled() || (mirrored && !problem_.mirrors)) break;
    const Observation& observation = problem_.observations[i];
    const Observation seen = mirrored ? observation.Mirrored() : observation;
    const auto misfit = [&](const Eigen::VectorXd& x) {
      return ComputeProfileRms(seen, material, x).value_or(kNoDrape);
    };
    Eigen::VectorXd x = Fall(material, seen, lift, task);
    if (!(misfit(x) < kRestFactor * most)) continue;
    x = Rest(material, std::move(x), task);
    const double rms = misfit(x);
    if (!(rms < most)) continue;
    most = rms;
    task.candidate.mirrored[i] = mirrored;
    task.candidate.shapes[i] = std::move(x);
  }
  return most;
}

SettleOptions CandidateFitter::CancellableSettle() const {
  SettleOptions settle = MakeSettleOptions(options_);
  settle.steps.cancel = settle.equilibrium.cancel = cancel_;
  return settle;
}

// Returns nothing where there is no drape or no outline.
std::optional<double> CandidateFitter::ComputeProfileRms(const Observation& observation,
                                                         const MaterialField& material,
                                                         const Eigen::VectorXd& x) const {
  if (x.size() == 0) return std::nullopt;
  return Misfit(*observation.Measured(), fine_.model(), material, x);
}

std::vector<double> CandidateFitter::ListProfileRms(const FitCandidate& candidate) const {
  const std::vector<Observation> observations = LaidObservations(problem_, candidate);
  const MaterialField material = FittedMaterial(options_, candidate);
  std::vector<double> errors;
  for (std::size_t i = 0; i < candidate.shapes.size(); ++i) {
    const std::optional<double> rms =
        ComputeProfileRms(observations[i], material, candidate.shapes[i]);
    if (!rms) return {};
    errors.push_back(*rms);
  }
  return errors;
}

void CandidateFitter::SettleGuess(CandidateTask& task) const {
  FitCandidate& candidate = task.candidate;
  candidate.base = GuessTables(ListStartTables(problem_), candidate.guess);
  candidate.theta = Eigen::VectorXd::Zero(Parametrisation(candidate).size());
  candidate.shapes.resize(problem_.observations.size());
  std::vector<double> errors;
  for (int i = 0; i < int(problem_.observations.size()); ++i)
    errors.push_back(SettleBest(candidate.base, i, candidate.guess.lifts[i], kNoDrape, task));
  const double rms = RootMeanSquare(errors);
  if (rms == kNoDrape) return candidate.shapes.clear();
  candidate.guess_rms = rms;
}

void CandidateFitter::CarryOver(const Mesh& from, CandidateTask& task) const {
  FitCandidate& candidate = task.candidate;
  const MaterialField base = candidate.base;
  const auto weights = InterpolationWeights(from, fine_.model().mesh.uv, Extrapolation::kLinear);
  std::vector<State> starts;
  for (const Eigen::VectorXd& x : candidate.shapes)
    starts.push_back({ReadPositions(weights, x), Eigen::VectorXd::Zero(fine_.model().num_dofs())});
  std::vector<double> errors;
  for (double stretch = 1.0; errors.empty() && stretch >= kLeastSoftening && !Cancelled();
       stretch *= kSoftening) {
    candidate.base = Scaled(base, stretch, 1.0);
    SettleCarried(starts, task);
    errors = ListProfileRms(candidate);
    if (!errors.empty() && stretch < 1.0) Log(task, "its stretch is scaled by %g", stretch);
  }
  const std::optional<double> cost =
      errors.empty() ? std::nullopt : ComputeCost(problem_, options_, fine_.model(), candidate);
  if (!cost) {
    candidate.shapes.clear();
    return Log(task, "its drapes are not stable on %d vertices", fine_.model().mesh.num_vertices());
  }
  Log(task, "taken over from %d vertices to %d, %.2f -> %.2f %s", from.num_vertices(),
      fine_.model().mesh.num_vertices(), candidate.profile_rms, RootMeanSquare(errors),
      MisfitUnit(problem_));
  candidate.cost = *cost;
  candidate.profile_rms = RootMeanSquare(errors);
}

// The drapes of the candidate from these starts; where one is not stable, from the start shapes.
void CandidateFitter::SettleCarried(const std::vector<State>& starts, CandidateTask& task) const {
  const MaterialField material = FittedMaterial(options_, task.candidate);
  const SettleOptions settle = CancellableSettle();
  const std::vector<Observation> observations = LaidObservations(problem_, task.candidate);
  for (int i = 0; i < int(starts.size()); ++i) {
    SettledDrape drape = SettleGuided(fine_, material, starts[i], observations[i], settle);
    ++task.counts.rollouts;
    const bool usable = drape.IsUsable(settle.solve_mode);
    task.candidate.shapes[i] = usable ? std::move(drape.rest.x) : Eigen::VectorXd();
    if (!usable) RetryGuesses(material, i, task);
  }
}

void CandidateFitter::RetryGuesses(CandidateTask& task) const {
  const MaterialField material = FittedMaterial(options_, task.candidate);
  for (int i = 0; i < int(problem_.observations.size()); ++i) RetryGuesses(material, i, task);
}

void CandidateFitter::RetryGuesses(const MaterialField& material, int i,
                                   CandidateTask& task) const {
  double best = ComputeProfileRms(LaidObservations(problem_, task.candidate)[i], material,
                                  task.candidate.shapes[i])
                    .value_or(kNoDrape);
  for (const double lift : options_.grid.lifts) {
    const double most = kRetryGain * best, rms = SettleBest(material, i, lift, most, task);
    if (rms == most) continue;
    Log(task, "image %d starts again from lift %g: %.2f -> %.2f %s", i + 1, lift, best, rms,
        MisfitUnit(problem_));
    best = rms;
  }
}

// Where the drape of observation i comes to rest from some starts near it, each pulled to what was
// measured: nearer to that than before, or as it was. Returns whether it is nearer.
bool CandidateFitter::SettleNearer(int i, CandidateTask& task) const {
  const MaterialField material = FittedMaterial(options_, task.candidate);
  const Observation observation = LaidObservations(problem_, task.candidate)[i];
  const std::shared_ptr<const Experiment> measured = observation.Measured();
  const SettleOptions settle = CancellableSettle();
  const Eigen::VectorXd fitted = task.candidate.shapes[i];
  const double before = ComputeProfileRms(observation, material, fitted).value_or(kNoDrape);
  double best = before;
  for (int number = 0; number <= measured->random_starts && !Cancelled(); ++number) {
    State start{fitted, Eigen::VectorXd::Zero(fitted.size())};
    if (number > 0) {
      start.x += MakeStart(*measured, fine_.model(), number).x;
      start.x -= fine_.model().mesh.rest_x;
    }
    SettledDrape drape = SettleGuided(fine_, material, start, observation, settle);
    ++task.counts.rollouts;
    if (!drape.IsUsable(settle.solve_mode)) continue;
    const double rms = ComputeProfileRms(observation, material, drape.rest.x).value_or(kNoDrape);
    if (!(rms < kPullGain * best)) continue;
    best = rms;
    task.candidate.shapes[i] = std::move(drape.rest.x);
  }
  if (best < before)
    Log(task, "drape %d is pulled to another: %.3f -> %.3f %s", i + 1, before, best,
        MisfitUnit(problem_));
  return best < before;
}

bool CandidateFitter::FitNearer(CandidateTask& task) const {
  const FitCandidate before = task.candidate;
  bool is_nearer = false;
  for (int i = 0; i < int(before.shapes.size()); ++i)
    is_nearer = SettleNearer(i, task) || is_nearer;
  if (is_nearer && !Cancelled()) {
    Fit(task, [](double) {});
    if (task.candidate.valid() && task.candidate.cost < before.cost) return true;
  }
  task.candidate = before;
  return false;
}

void CandidateFitter::Fit(CandidateTask& task, const std::function<void(double)>& progress) const {
  const TableParametrisation parametrisation = Parametrisation(task.candidate);
  RolloutResiduals residuals = Residuals(parametrisation, task.candidate);
  FitOptions fit_options = MakeFitOptions();
  fit_options.trust_region.progress = [&](const FitIteration& iteration) {
    progress(iteration.iteration / std::max(1.0, double(fit_options.trust_region.max_iterations)));
  };
  const FitSummary summary = drape::Fit(residuals, fit_options);
  task.iterations += static_cast<int>(summary.iterations.size()) - 1;
  task.counts += summary.counts;
  if (summary.termination == FitTermination::kFailed) {
    task.candidate.shapes.clear();
    Log(task, "failed, %s", summary.message.c_str());
  } else {
    TakeResult(summary, residuals.starts(), task);
  }
}

void CandidateFitter::TakeResult(const FitSummary& summary, const std::vector<State>& drapes,
                                 CandidateTask& task) const {
  FitCandidate& candidate = task.candidate;
  candidate.theta = summary.theta;
  candidate.cost = summary.final_cost;
  candidate.termination = summary.termination;
  candidate.iterations += static_cast<int>(summary.iterations.size()) - 1;
  for (std::size_t i = 0; i < candidate.shapes.size(); ++i) candidate.shapes[i] = drapes[i].x;
  candidate.profile_rms = RootMeanSquare(ListProfileRms(candidate));
  Log(task,
      "%sstretch %g, bend %g, lift %g, cost %.1f -> %.1f, %.2f %s, %s, %d branch jumps, %d failed",
      candidate.is_carried ? "from the part before, " : "", candidate.guess.stretch,
      candidate.guess.bend, candidate.guess.lifts.front(), summary.initial_cost, summary.final_cost,
      candidate.profile_rms, MisfitUnit(problem_), ToString(summary.termination),
      summary.counts.jumps, summary.counts.failed);
}

Eigen::MatrixXd CandidateFitter::Jacobian(const FitCandidate& candidate) const {
  const TableParametrisation parametrisation = Parametrisation(candidate);
  RolloutResiduals residuals = Residuals(parametrisation, candidate);
  residuals.PrepareForEvaluation(true, true);
  return residuals.accepted().jacobian;
}

TableParametrisation CandidateFitter::Parametrisation(const FitCandidate& candidate) const {
  return {candidate.base, options_.parameters};
}

RolloutResiduals CandidateFitter::Residuals(const TableParametrisation& parametrisation,
                                            const FitCandidate& candidate) const {
  const ResidualOptions options = MakeResidualOptions();
  std::vector<RolloutBlock> blocks =
      MakeBlocks(&fine_, LaidObservations(problem_, candidate), AtRest(candidate.shapes), options);
  for (RolloutBlock& block : FurtherBlocks(problem_, cancel_)) blocks.push_back(std::move(block));
  RolloutResiduals residuals(&parametrisation, std::move(blocks), options);
  Eigen::Map<Eigen::VectorXd>(residuals.theta(), candidate.theta.size()) = candidate.theta;
  return residuals;
}

ResidualOptions CandidateFitter::MakeResidualOptions() const {
  ResidualOptions residuals = options_.residuals;
  residuals.rollout.cancel = residuals.equilibrium.cancel = cancel_;
  return residuals;
}

FitOptions CandidateFitter::MakeFitOptions() const {
  const bool last = round_ + 1 == static_cast<int>(options_.candidates_per_round.size());
  FitOptions fit;
  fit.prior_sigma = options_.prior_sigma;
  fit.trust_region.max_iterations = options_.iterations[round_];
  fit.trust_region.initial_damping = options_.initial_damping;
  fit.trust_region.cost_tolerance = last ? kLastCostTolerance : kRoundTolerance;
  fit.trust_region.cancel = cancel_;
  if (FindExperiment(problem_) != nullptr) fit.trust_region.least_scale = kExperimentLeastScale;
  return fit;
}

Eigen::MatrixXd FitJacobian(const FitProblem& problem, const StagedFitOptions& options,
                            const FitCandidate& candidate) {
  return CandidateFitter(problem, options, *problem.fine, nullptr, 0).Jacobian(candidate);
}

}  // namespace drape
