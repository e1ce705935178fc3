// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/staged_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "solver/fit/protocol/candidate_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// Branches in work at a time: enough for batches that fill a GPU. Each holds derivatives of its
// drapes: 1.1 MB an image at 1,200 vertices, twice that while it evaluates.
constexpr int kSideBySide = 64;

class StagedFitter {
 public:
  StagedFitter(const FitProblem& problem, const StagedFitOptions& options,
               const StagedFitCallbacks& callbacks)
      : problem_(problem), options_(options), callbacks_(callbacks) {}

  StagedFitState Run(StagedFitState state) {
    while (!Finished(state) && !Cancelled()) {
      lap_ = std::chrono::steady_clock::now();
      if (!state.grid_done) {
        RunGrid(state);
        state.grid_seconds += Lap();
        Save(state);
      } else {
        if (DoneCandidates(state) == 0) StartRound(state);
        RunEquilibria(state);
      }
    }
    return state;
  }

 private:
  bool Cancelled() const { return callbacks_.cancel != nullptr && callbacks_.cancel->load(); }
  int rounds() const { return static_cast<int>(options_.keep.size()); }
  bool Finished(const StagedFitState& state) const {
    return state.grid_done && (state.round == rounds() || state.branches.empty());
  }
  void Save(const StagedFitState& state) const {
    if (!Cancelled() && callbacks_.save) callbacks_.save(state);
  }
  // Seconds since the last one.
  double Lap() {
    const auto before = std::exchange(lap_, std::chrono::steady_clock::now());
    return std::chrono::duration<double>(lap_ - before).count();
  }

  void RunGrid(StagedFitState& state) const {
    const auto progress = [&](double share) { Report("seed grid", kGridShare * share, 0.0); };
    const std::vector<InitialGuess> seeds = RankInitialGuesses(
        *problem_.coarse, problem_.material, problem_.targets,
        Refined(options_.grid, options_.keep.front()), callbacks_.cancel, progress);
    if (Cancelled()) return;
    state.counts.rollouts += static_cast<int>(seeds.size() * problem_.targets.size());
    for (std::size_t i = 0; i < seeds.size() && i < kSpareSeeds * options_.keep.front(); ++i)
      state.branches.emplace_back().seed = seeds[i];
    state.grid_done = true;
  }

  // The best branches of the round before.
  void StartRound(StagedFitState& state) const {
    if (state.round == 0) return;
    std::erase_if(state.branches, [](const FitCandidate& branch) { return !branch.valid(); });
    std::stable_sort(state.branches.begin(), state.branches.end(),
                     [](const FitCandidate& a, const FitCandidate& b) { return a.cost < b.cost; });
    if (int(state.branches.size()) > options_.keep[state.round])
      state.branches.resize(options_.keep[state.round]);
  }

  // Branches of this round that are done, failed seeds aside.
  static int Succeeded(const StagedFitState& state) {
    return static_cast<int>(
        std::count_if(state.branches.begin(), state.branches.end(),
                      [](const FitCandidate& branch) { return branch.done && branch.valid(); }));
  }

  // Up to `count` branches that are not done, from `first` on.
  static std::vector<CandidateTask> Open(const StagedFitState& state, int first, int count) {
    std::vector<CandidateTask> open;
    for (int i = first; i < int(state.branches.size()) && int(open.size()) < count; ++i)
      if (!state.branches[i].done) open.push_back({i, state.branches[i], 0, {}, {}});
    return open;
  }

  // The branches of this round that are not done; in the first round, as many as it still wants.
  void RunEquilibria(StagedFitState& state) {
    std::vector<CandidateTask> work =
        state.round == 0 ? Seeded(state) : Open(state, 0, int(state.branches.size()));
    const int round = state.round;
    shares_.assign(work.size(), 0.0);
    Gather(work, round,
           [&](const CandidateFitter& fitter, CandidateTask& mine, BatchingBackend& task) {
             FitOneCandidate(fitter, round, mine, [&](double share) {
               task.RunSerially([&] {
                 shares_[task.index()] = share;
                 ReportEquilibria(state);
               });
             });
             task.RunSerially([&] {
               shares_[task.index()] = 0.0;
               Finish(state, mine);
             });
           });
  }

  // Next branches with drapes of their own, so that all that succeed fill the first round: no
  // seed is settled that one branch after the other would not have come to.
  std::vector<CandidateTask> Seeded(StagedFitState& state) {
    std::vector<CandidateTask> seeded;
    for (int next = 0; !Cancelled();) {
      const int wanted = options_.keep.front() - Succeeded(state) - int(seeded.size());
      std::vector<CandidateTask> work = Open(state, next, wanted);
      if (work.empty()) break;
      next = work.back().index + 1;
      Gather(work, 0, [](const CandidateFitter& fitter, CandidateTask& mine, BatchingBackend&) {
        fitter.Seed(mine);
      });
      for (CandidateTask& mine : work) {
        state.branches[mine.index].seed_rms = mine.branch.seed_rms;
        if (SameDrapeBefore(mine, state)) mine.branch.shapes.clear();
        if (mine.branch.valid()) {
          seeded.push_back(std::move(mine));
        } else {
          Finish(state, mine);
        }
      }
    }
    return seeded;
  }

  // Seeds of one material with different lifts often fall into one drape.
  static bool SameDrapeBefore(const CandidateTask& work, const StagedFitState& state) {
    return std::any_of(state.branches.begin(), state.branches.begin() + work.index,
                       [&](const FitCandidate& before) {
                         return before.seed.stretch == work.branch.seed.stretch &&
                                before.seed.bend == work.branch.seed.bend &&
                                std::abs(before.seed_rms - work.branch.seed_rms) < kSameRms;
                       });
  }

  void Gather(
      std::vector<CandidateTask>& work, int round,
      const std::function<void(const CandidateFitter&, CandidateTask&, BatchingBackend&)>& act) {
    RunBatched(*problem_.fine, int(work.size()), kSideBySide, [&](BatchingBackend& task) {
      const CandidateFitter fitter(problem_, options_, task, callbacks_.cancel, round);
      act(fitter, work[task.index()], task);
    });
  }

  void FitOneCandidate(const CandidateFitter& fitter, int round, CandidateTask& work,
                       const std::function<void(double)>& progress) const {
    FitCandidate& branch = work.branch;
    const FitCandidate before = branch;
    if (round == 1) fitter.Reseed(work);
    if (!Cancelled()) fitter.Fit(work, progress);
    // What an earlier round had fitted stands where this one fails, or ends before it has fitted.
    const bool unfitted = !branch.valid() || (Cancelled() && branch.cost == before.cost);
    if (round > 0 && unfitted) branch = before;
  }

  // The state gets a branch; a cancelled one is not done.
  void Finish(StagedFitState& state, const CandidateTask& work) {
    FitCandidate& branch = state.branches[work.index];
    branch = work.branch;
    branch.done = !Cancelled();
    state.iterations += work.iterations;
    state.counts += work.counts;
    for (const std::string& line : work.log) Log(line);
    const int done = DoneCandidates(state), succeeded = Succeeded(state);
    if (done == int(state.branches.size()) || succeeded == options_.keep[state.round]) {
      if (state.round == 0) LogStarts(succeeded);
      for (FitCandidate& each : state.branches) each.done = false;
      ++state.round;
    }
    state.fit_seconds += Lap();
    Save(state);
  }

  void Log(const std::string& line) const {
    if (callbacks_.log) callbacks_.log(line);
  }
  void LogStarts(int count) const {
    if (count < options_.keep.front())
      Log("round 1: " + std::to_string(count) + " starts of " +
          std::to_string(options_.keep.front()) + ": the grid has no more drapes of their own");
  }

  void Report(const std::string& stage, double fraction, double rms) const {
    if (callbacks_.progress) callbacks_.progress(stage, fraction, rms);
  }
  void ReportEquilibria(const StagedFitState& state) const {
    double total = 0.0, done = 0.0;
    for (int round = 0; round < rounds(); ++round) {
      const double each = kBranchOverhead + options_.iterations[round];
      total += options_.keep[round] * each;
      if (round < state.round) done += options_.keep[round] * each;
      if (round == state.round)
        done += (Succeeded(state) + std::accumulate(shares_.begin(), shares_.end(), 0.0)) * each;
    }
    const FitCandidate* best = Best(state);
    Report("round " + std::to_string(state.round + 1),
           kGridShare + (1.0 - kGridShare) * done / total,
           best == nullptr ? 0.0 : best->profile_rms);
  }

  static constexpr double kGridShare = 0.25;      // of the time, for the progress line
  static constexpr double kBranchOverhead = 5.0;  // of a branch's seeds, in iterations
  static constexpr std::size_t kSpareSeeds = 4;
  static constexpr double kSameRms = 1e-4;  // [px]

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  const StagedFitCallbacks& callbacks_;
  std::chrono::steady_clock::time_point lap_;
  std::vector<double> shares_;  // of the iterations of each branch in work
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

SettleOptions MakeSettleOptions(const StagedFitOptions& options) {
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

int DoneCandidates(const StagedFitState& state) {
  return static_cast<int>(std::count_if(state.branches.begin(), state.branches.end(),
                                        [](const FitCandidate& branch) { return branch.done; }));
}

const FitCandidate* Best(const StagedFitState& state) {
  const FitCandidate* best = nullptr;
  for (const FitCandidate& branch : state.branches)
    if (branch.valid() && branch.termination != FitTermination::kFailed &&
        (best == nullptr || branch.cost < best->cost))
      best = &branch;
  return best;
}

MaterialField FittedMaterial(const FitProblem& problem, const StagedFitOptions& options,
                             const FitCandidate& branch) {
  return TableParametrisation(Scaled(problem.material, branch.seed.stretch, branch.seed.bend),
                              options.parameters)
      .Material(branch.theta);
}

Eigen::MatrixXd FitJacobian(const FitProblem& problem, const StagedFitOptions& options,
                            const FitCandidate& branch) {
  return CandidateFitter(problem, options, *problem.fine, nullptr, 0).Jacobian(branch);
}

}  // namespace drape
