// SPDX-License-Identifier: Apache-2.0
#include "solver/staged_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "losses/metrics.h"
#include "losses/outline.h"

namespace drape {
namespace {

// A seed replaces a fitted drape when it comes this much nearer.
constexpr double kReseedGain = 0.97;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string Line(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

class StagedFitter {
 public:
  StagedFitter(const FitProblem& problem, const StagedFitOptions& options,
               const StagedFitCallbacks& callbacks)
      : problem_(problem), options_(options), callbacks_(callbacks) {}

  StagedFitState Run(StagedFitState state) const {
    while (!Finished(state) && !Cancelled()) {
      const auto start = std::chrono::steady_clock::now();
      if (!state.grid_done) {
        RunGrid(state);
        state.grid_seconds += SecondsSince(start);
      } else {
        if (state.branch == 0) StartRound(state);
        if (!state.branches.empty()) RunBranch(state);
        state.fit_seconds += SecondsSince(start);
      }
      if (!Cancelled() && callbacks_.save) callbacks_.save(state);
    }
    return state;
  }

 private:
  bool Cancelled() const { return callbacks_.cancel != nullptr && callbacks_.cancel->load(); }
  int rounds() const { return static_cast<int>(options_.keep.size()); }
  bool Finished(const StagedFitState& state) const {
    return state.grid_done && (state.round == rounds() || state.branches.empty());
  }
  void Log(const std::string& line) const {
    if (callbacks_.log) callbacks_.log(line);
  }

  void RunGrid(StagedFitState& state) const {
    const auto progress = [&](double share) { Report("seed grid", kGridShare * share, 0.0); };
    std::vector<SeedCandidate> seeds =
        RankSeeds(*problem_.coarse, problem_.material, problem_.targets, options_.grid,
                  callbacks_.cancel, progress);
    if (Cancelled()) return;
    state.counts.rollouts += static_cast<int>(seeds.size() * problem_.targets.size());
    for (std::size_t i = 0; i < seeds.size() && i < kSpareSeeds * options_.keep.front(); ++i)
      state.branches.emplace_back().seed = seeds[i];
    state.grid_done = true;
  }

  // The best branches of the round before.
  void StartRound(StagedFitState& state) const {
    if (state.round == 0) return;
    std::erase_if(state.branches, [](const BranchFit& branch) { return !branch.valid(); });
    std::stable_sort(state.branches.begin(), state.branches.end(),
                     [](const BranchFit& a, const BranchFit& b) { return a.cost < b.cost; });
    if (int(state.branches.size()) > options_.keep[state.round])
      state.branches.resize(options_.keep[state.round]);
  }

  // Branches of this round that are done, failed seeds aside.
  static int Done(const StagedFitState& state) {
    return static_cast<int>(std::count_if(state.branches.begin(),
                                          state.branches.begin() + state.branch,
                                          [](const BranchFit& branch) { return branch.valid(); }));
  }

  void RunBranch(StagedFitState& state) const {
    BranchFit& branch = state.branches[state.branch];
    const BranchFit before = branch;
    if (state.round == 0) {
      Seed(branch, state);
    } else if (state.round == 1) {
      Reseed(branch, state);
    }
    if (branch.valid() && !Cancelled()) FitBranch(branch, state);
    // What an earlier round had fitted stands where this one fails, or ends before it has fitted.
    const bool unfitted = !branch.valid() || (Cancelled() && branch.cost == before.cost);
    if (before.valid() && unfitted) branch = before;
    if (Cancelled()) return;
    ++state.branch;
    if (state.branch == int(state.branches.size()) || Done(state) == options_.keep[state.round]) {
      state.branch = 0;
      ++state.round;
    }
  }

  // The drape of target i that grows from its seed under a material; empty when it is not stable.
  Eigen::VectorXd SettledSeed(const MaterialField& material, int i, double lift,
                              StagedFitState& state) const {
    SettleOptions settle = SettleOptionsOf(options_);
    settle.steps.cancel = settle.equilibrium.cancel = callbacks_.cancel;
    ++state.counts.rollouts;
    const State seed = SeedState(problem_.fine->model(), problem_.targets[i], lift);
    SettledDrape drape =
        std::move(Settle(*problem_.fine, material, {&seed, 1}, settle).front());
    if (drape.Stands(options_.integrator)) return std::move(drape.rest.x);
    if (drape.steps == RolloutStatus::kOk)
      Log(Line(
          "round %d, branch %d: a seed's drape is %s after %d Newton iterations (residual %.1e)",
          state.round + 1, state.branch + 1, ToString(drape.rest.status), drape.rest.iterations,
          drape.rest.residual));
    return {};
  }

  // Root mean square distance of a drape from its outline [px]; negative when it has none.
  double ProfileRmsOf(int i, const Eigen::VectorXd& x) const {
    const Target& target = problem_.targets[i];
    Outline outline;
    if (x.size() == 0 || !OutlineFromMesh(problem_.fine->model().mesh, x, target.camera,
                                          options_.angles, &outline)) {
      return -1.0;
    }
    return ProfileRms(outline.radius, target.radius);
  }

  void Seed(BranchFit& branch, StagedFitState& state) const {
    branch.theta = Eigen::VectorXd::Zero(Parametrisation(branch).size());
    const MaterialField material = Scaled(problem_.material, branch.seed.stretch, branch.seed.bend);
    std::vector<Eigen::VectorXd> shapes;
    double sum = 0.0;
    for (int i = 0; i < int(problem_.targets.size()); ++i) {
      shapes.push_back(SettledSeed(material, i, branch.seed.lifts[i], state));
      const double rms = ProfileRmsOf(i, shapes.back());
      if (rms < 0.0) return;
      sum += rms * rms;
    }
    branch.seed_rms = std::sqrt(sum / double(shapes.size()));
    if (!SameDrapeBefore(branch, state)) branch.shapes = std::move(shapes);
  }

  // Seeds of one material with different lifts often fall into one drape.
  static bool SameDrapeBefore(const BranchFit& branch, const StagedFitState& state) {
    return std::any_of(state.branches.begin(), state.branches.begin() + state.branch,
                       [&](const BranchFit& before) {
                         return before.seed.stretch == branch.seed.stretch &&
                                before.seed.bend == branch.seed.bend &&
                                std::abs(before.seed_rms - branch.seed_rms) < kSameRms;
                       });
  }

  void Reseed(BranchFit& branch, StagedFitState& state) const {
    const MaterialField material = FittedMaterial(problem_, options_, branch);
    for (int i = 0; i < int(problem_.targets.size()); ++i) {
      double best = ProfileRmsOf(i, branch.shapes[i]);
      for (const double lift : options_.grid.lifts) {
        if (Cancelled()) return;
        Eigen::VectorXd x = SettledSeed(material, i, lift, state);
        const double rms = ProfileRmsOf(i, x);
        if (rms < 0.0 || rms > kReseedGain * best) continue;
        Log(Line("round %d, branch %d: image %d seeded anew, lift %g: %.2f -> %.2f px",
                 state.round + 1, state.branch + 1, i + 1, lift, best, rms));
        best = rms;
        branch.shapes[i] = std::move(x);
      }
    }
  }

  MaterialParametrisation Parametrisation(const BranchFit& branch) const {
    return {Scaled(problem_.material, branch.seed.stretch, branch.seed.bend), options_.parameters};
  }

  void FitBranch(BranchFit& branch, StagedFitState& state) const {
    const MaterialParametrisation parametrisation = Parametrisation(branch);
    std::vector<Target> targets = WithStarts(branch);
    RolloutBatch batch(problem_.fine, &parametrisation, &targets, BatchOptionsOf());
    Eigen::Map<Eigen::VectorXd>(batch.theta(), branch.theta.size()) = branch.theta;
    FitOptions fit_options;
    fit_options.prior_sigma = options_.prior_sigma;
    fit_options.max_iterations = options_.iterations[state.round];
    fit_options.initial_damping = options_.initial_damping;
    fit_options.cost_tolerance =
        state.round + 1 == rounds() ? kLastCostTolerance : kCostTolerance;
    fit_options.cancel = callbacks_.cancel;
    fit_options.progress = [&](const FitIteration& iteration) {
      ReportBranch(state, iteration.iteration / std::max(1.0, double(fit_options.max_iterations)));
    };
    std::optional<StripReadings> tests = Tests();
    const FitSummary summary = Fit(batch, fit_options, tests ? &*tests : nullptr);
    Count(summary, state);
    if (summary.termination == FitTermination::kFailed) {
      branch.shapes.clear();
      Log(Line("round %d, branch %d: failed, %s", state.round + 1, state.branch + 1,
               summary.message.c_str()));
      return;
    }
    branch.theta = summary.theta;
    branch.cost = summary.final_cost;
    branch.termination = summary.termination;
    branch.iterations += static_cast<int>(summary.iterations.size()) - 1;
    double sum = 0.0;
    for (int i = 0; i < int(targets.size()); ++i) {
      branch.shapes[i] = targets[i].start.x;
      sum += std::pow(ProfileRmsOf(i, branch.shapes[i]), 2);
    }
    branch.profile_rms = std::sqrt(sum / double(targets.size()));
    Log(Line("round %d, branch %d: stretch %g, bend %g, lift %g, cost %.1f -> %.1f, %.2f px, %s, "
             "%d branch jumps, %d failed",
             state.round + 1, state.branch + 1, branch.seed.stretch, branch.seed.bend,
             branch.seed.lifts.front(), summary.initial_cost, summary.final_cost,
             branch.profile_rms, ToString(summary.termination), summary.counts.jumps,
             summary.counts.failed));
  }

  std::vector<Target> WithStarts(const BranchFit& branch) const {
    std::vector<Target> targets = problem_.targets;
    for (std::size_t i = 0; i < targets.size(); ++i)
      targets[i].start = {branch.shapes[i], Eigen::VectorXd::Zero(branch.shapes[i].size())};
    return targets;
  }

  std::optional<StripReadings> Tests() const {
    return problem_.tests == nullptr ? std::nullopt : std::optional(problem_.tests->Clone());
  }

  BatchOptions BatchOptionsOf() const {
    BatchOptions batch;
    batch.integrator = options_.integrator;
    batch.equilibrium.max_iterations = options_.newton_iterations;
    batch.equilibrium.cancel = callbacks_.cancel;
    batch.rollout.h = options_.settle_h;
    batch.rollout.steps = options_.settle_steps;
    batch.rollout.cancel = callbacks_.cancel;
    batch.sigma_px = options_.sigma_px;
    batch.max_outline_change = options_.max_outline_change;
    batch.max_jump = options_.max_jump;
    batch.warm_restart = options_.warm_restart;
    return batch;
  }

  static void Count(const FitSummary& summary, StagedFitState& state) {
    state.iterations += static_cast<int>(summary.iterations.size()) - 1;
    state.counts.rollouts += summary.counts.rollouts;
    state.counts.tangents += summary.counts.tangents;
    state.counts.failed += summary.counts.failed;
    state.counts.jumps += summary.counts.jumps;
    state.counts.capped += summary.counts.capped;
  }

  void Report(const std::string& stage, double fraction, double rms) const {
    if (callbacks_.progress) callbacks_.progress(stage, fraction, rms);
  }
  void ReportBranch(const StagedFitState& state, double share_of_branch) const {
    double total = 0.0, done = 0.0;
    for (int round = 0; round < rounds(); ++round) {
      const double each = kBranchOverhead + options_.iterations[round];
      total += options_.keep[round] * each;
      if (round < state.round) done += options_.keep[round] * each;
      if (round == state.round) done += (Done(state) + share_of_branch) * each;
    }
    const BranchFit* best = Best(state);
    Report("round " + std::to_string(state.round + 1),
           kGridShare + (1.0 - kGridShare) * done / total,
           best == nullptr ? 0.0 : best->profile_rms);
  }

  friend Eigen::MatrixXd drape::FitJacobian(const FitProblem&, const StagedFitOptions&,
                                            const BranchFit&);

  static constexpr double kGridShare = 0.25;     // of the time, for the progress line
  static constexpr double kBranchOverhead = 5.0; // of a branch's seeds, in iterations
  // A valley of nearly equal drapes is long: the last round goes to its end.
  static constexpr double kCostTolerance = 1e-3, kLastCostTolerance = 1e-5;
  static constexpr std::size_t kSpareSeeds = 4;
  static constexpr double kSameRms = 1e-4;       // [px]

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  const StagedFitCallbacks& callbacks_;
};

}  // namespace

void StagedFitOptions::Check() const {
  grid.Check();
  CHECK(!keep.empty() && keep.size() == iterations.size());
  for (const int count : keep) CHECK_GT(count, 0);
  for (const int count : iterations) CHECK_GE(count, 0);
  CHECK_GT(prior_sigma, 0.0);
  CHECK_GT(sigma_px, 0.0);
  CHECK_GT(initial_damping, 0.0);
  CHECK_GT(max_outline_change, 0.0);
  CHECK_GT(max_jump, 0.0);
  CHECK_GT(newton_iterations, 0);
  CHECK_GT(angles, 2);
}

SettleOptions SettleOptionsOf(const StagedFitOptions& options) {
  constexpr int kSeedNewtonFactor = 2;  // a seed starts further away than a trial
  SettleOptions settle;
  settle.steps.h = options.settle_h;
  settle.steps.steps = options.settle_steps;
  settle.integrator = options.integrator;
  settle.equilibrium.max_iterations = kSeedNewtonFactor * options.newton_iterations;
  return settle;
}

StagedFitState RunStagedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitCallbacks& callbacks) {
  options.Check();
  CHECK(!problem.targets.empty());
  return StagedFitter(problem, options, callbacks).Run(std::move(state));
}

const BranchFit* Best(const StagedFitState& state) {
  const BranchFit* best = nullptr;
  for (const BranchFit& branch : state.branches)
    if (branch.valid() && branch.termination != FitTermination::kFailed &&
        (best == nullptr || branch.cost < best->cost))
      best = &branch;
  return best;
}

MaterialField FittedMaterial(const FitProblem& problem, const StagedFitOptions& options,
                             const BranchFit& branch) {
  return MaterialParametrisation(Scaled(problem.material, branch.seed.stretch, branch.seed.bend),
                                 options.parameters)
      .Material(branch.theta);
}

Eigen::MatrixXd FitJacobian(const FitProblem& problem, const StagedFitOptions& options,
                            const BranchFit& branch) {
  const StagedFitCallbacks none;
  const StagedFitter fitter(problem, options, none);
  const MaterialParametrisation parametrisation = fitter.Parametrisation(branch);
  std::vector<Target> targets = fitter.WithStarts(branch);
  RolloutBatch batch(problem.fine, &parametrisation, &targets, fitter.BatchOptionsOf());
  Eigen::Map<Eigen::VectorXd>(batch.theta(), branch.theta.size()) = branch.theta;
  batch.PrepareForEvaluation(true, true);
  if (problem.tests == nullptr || !batch.has_accepted()) return batch.accepted_jacobian();
  Eigen::VectorXd residual;
  RowMatrix of_tests;
  if (!fitter.Tests()->Evaluate(parametrisation, branch.theta, &residual, &of_tests)) return {};
  Eigen::MatrixXd jacobian(batch.accepted_jacobian().rows() + of_tests.rows(), of_tests.cols());
  jacobian << batch.accepted_jacobian(), of_tests;
  return jacobian;
}

}  // namespace drape
