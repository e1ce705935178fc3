// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/staged_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// Measured from 300 to 1,200 vertices on one core.
constexpr double kGrowth = 1.3;             // cost of a step ~ vertices^kGrowth
constexpr double kNewtonSteps = 40.0;       // of an equilibrium after the settle steps
constexpr double kEvaluationSteps = 10.0;   // of an iteration without its derivatives
constexpr double kStepsPerParameter = 0.8;  // of its derivatives
constexpr double kPoses = 2.0;              // of a mesh, itself and its mirror image
constexpr double kSettledPerStart = 1.5;    // guesses settled for a candidate of the first round
constexpr int kSurelyTaken = 8;             // iterations; of more, fits usually take half

double ExpectIterations(int most) {
  return most <= kSurelyTaken ? most : 0.5 * (most + kSurelyTaken);
}

// The time of `count` equal tasks.
double Elapsed(int count, int threads, double each) {
  return each * std::ceil(double(count) / std::max(1, threads));
}

// Candidates in work at a time: enough for batches that fill a GPU. Each holds derivatives of its
// drapes: 1.1 MB per image at 1,200 vertices, twice that during an evaluation.
constexpr int kSideBySide = 64;

// How many times the candidates of the first round are kept as guesses; of a pool, settled on the
// fine cloth.
constexpr int kSpareGuesses = 4, kSettledOfPool = 2;
// The coarse cloth ranks the guesses of a pool where the fine one has so many times its vertices.
constexpr int kMuchCoarser = 3;

// Candidates that the present round fits: in the first one more, where one is carried over.
int CountWanted(const StagedFitOptions& options, const StagedFitState& state) {
  return options.candidates_per_round.at(state.round) + (state.round == 0 && state.carried ? 1 : 0);
}

// The number of done candidates that have a result.
int SucceededCandidates(const StagedFitState& state) {
  return static_cast<int>(std::count_if(
      state.candidates.begin(), state.candidates.end(),
      [](const FitCandidate& candidate) { return candidate.done && candidate.valid(); }));
}

class StagedFitter {
 public:
  StagedFitter(const FitProblem& problem, const StagedFitOptions& options,
               const StagedFitControl& control)
      : problem_(problem),
        options_(options),
        control_(control),
        work_(ExpectFitWork(problem, options)) {}

  StagedFitState Run(StagedFitState state) {
    while (!Finished(state) && !Cancelled()) {
      lap_ = std::chrono::steady_clock::now();
      if (!state.grid_done) {
        if (problem_.is_pooled)
          TakePooled(state);
        else
          RunGrid(state);
        state.grid_seconds += Lap();
        Save(state);
      } else {
        if (DoneCandidates(state) == 0) StartRound(state);
        RunRound(state);
      }
    }
    return state;
  }

 private:
  bool Cancelled() const { return control_.cancelled(); }
  int rounds() const { return static_cast<int>(options_.candidates_per_round.size()); }
  bool Finished(const StagedFitState& state) const {
    return state.grid_done && (state.round == rounds() || state.candidates.empty());
  }
  void Save(const StagedFitState& state) const {
    if (!Cancelled() && control_.save) control_.save(state);
  }
  // Seconds since the last one.
  double Lap() {
    const auto before = std::exchange(lap_, std::chrono::steady_clock::now());
    return std::chrono::duration<double>(lap_ - before).count();
  }

  // A guess for each start table and lift.
  void TakePooled(StagedFitState& state) const {
    const auto tables = static_cast<int>(ListStartTables(problem_).size());
    for (int table = 0; table < tables; ++table)
      for (const double lift : options_.grid.lifts)
        state.candidates.emplace_back().guess = {
            .table = table, .lifts = std::vector<double>(problem_.observations.size(), lift)};
    state.grid_done = true;
  }

  void RunGrid(StagedFitState& state) {
    RunControl control;
    control.cancel = control_.cancel;
    control.progress = [&](double share, const std::string&) {
      Report("initial guesses", work_.initial_guesses * share, 0.0);
    };
    TryInitialGuesses(*problem_.coarse, ListStartTables(problem_), problem_.observations,
                      options_.grid, control, state.tried, [&] {
                        state.grid_seconds += Lap();
                        Save(state);
                      });
    if (Cancelled()) return;
    const std::vector<InitialGuess> guesses = RankGuesses(std::exchange(state.tried, {}));
    state.counts.rollouts += static_cast<int>(guesses.size() * problem_.observations.size());
    const std::size_t kept = kSpareGuesses * options_.candidates_per_round.front();
    if (state.carried) state.candidates.push_back(*state.carried);
    for (std::size_t i = 0; i < guesses.size() && i < kept; ++i)
      state.candidates.emplace_back().guess = guesses[i];
    state.grid_done = true;
  }

  // Keeps the best candidates of the round before.
  void StartRound(StagedFitState& state) const {
    if (state.round == 0) return;
    std::erase_if(state.candidates,
                  [](const FitCandidate& candidate) { return !candidate.valid(); });
    std::stable_sort(state.candidates.begin(), state.candidates.end(),
                     [](const FitCandidate& a, const FitCandidate& b) { return a.cost < b.cost; });
    if (int(state.candidates.size()) > options_.candidates_per_round[state.round])
      state.candidates.resize(options_.candidates_per_round[state.round]);
  }

  // Up to `count` candidates that are not done, from `first` on.
  static std::vector<CandidateTask> Open(const StagedFitState& state, int first, int count) {
    std::vector<CandidateTask> open;
    for (int i = first; i < int(state.candidates.size()) && int(open.size()) < count; ++i)
      if (!state.candidates[i].done) open.push_back({i, state.candidates[i], 0, {}, {}});
    return open;
  }

  // Fits the candidates of this round that are not done; in the first round, as many as it still
  // needs.
  void RunRound(StagedFitState& state) {
    std::vector<CandidateTask> work =
        state.round == 0 ? SettledGuesses(state) : Open(state, 0, int(state.candidates.size()));
    const int round = state.round;
    shares_.assign(work.size(), 0.0);
    RunSideBySide(work, round,
                  [&](const CandidateFitter& fitter, CandidateTask& mine, BatchingBackend& task) {
                    FitOneCandidate(fitter, round, mine, [&](double share) {
                      task.RunSerially([&] {
                        shares_[task.index()] = share;
                        ReportRound(state, round);
                      });
                    });
                    task.RunSerially([&] {
                      shares_[task.index()] = 0.0;
                      Finish(state, mine);
                    });
                  });
  }

  // The next candidates with drapes of their own, enough to fill the first round if all succeed. No
  // guess is settled that fitting one candidate after the other would not have reached; those of a
  // pool are all settled, on the coarse cloth and then the nearest on the fine one, of which the
  // nearest are taken.
  std::vector<CandidateTask> SettledGuesses(StagedFitState& state) {
    if (problem_.is_pooled) KeepNearestOnCoarse(state);
    std::vector<CandidateTask> settled;
    const int round = state.round;  // ends where the last guess has no drape
    for (int next = 0; state.round == round && !Cancelled();) {
      const int wanted =
          CountWanted(options_, state) - SucceededCandidates(state) - int(settled.size());
      std::vector<CandidateTask> work =
          Open(state, next, problem_.is_pooled ? int(state.candidates.size()) : wanted);
      if (work.empty()) break;
      next = work.back().index + 1;
      RunSideBySide(work, 0,
                    [](const CandidateFitter& fitter, CandidateTask& mine, BatchingBackend&) {
                      if (!mine.candidate.is_carried) fitter.SettleGuess(mine);
                    });
      for (CandidateTask& mine : work) {
        state.candidates[mine.index].guess_rms = mine.candidate.guess_rms;
        if (RepeatsEarlierDrape(mine, state)) mine.candidate.shapes.clear();
        if (mine.candidate.valid()) {
          settled.push_back(std::move(mine));
        } else {
          Finish(state, mine);
        }
      }
    }
    if (problem_.is_pooled && !settled.empty()) KeepNearest(state, settled);
    return settled;
  }

  // Finishes all guesses but those that are nearest on the coarse cloth.
  void KeepNearestOnCoarse(StagedFitState& state) {
    std::vector<CandidateTask> work = Open(state, 0, int(state.candidates.size()));
    const std::size_t kept = kSettledOfPool * options_.candidates_per_round.front();
    const int coarse = problem_.coarse->model().mesh.num_vertices();
    if (work.size() <= kept || kMuchCoarser * coarse > problem_.fine->model().mesh.num_vertices())
      return;
    RunBatched(*problem_.coarse, int(work.size()), kSideBySide, [&](BatchingBackend& task) {
      const CandidateFitter fitter(problem_, options_, task, control_.cancel, 0);
      fitter.SettleGuess(work[task.index()]);
    });
    const auto rank = [](const CandidateTask& task) {
      return std::pair(!task.candidate.valid(), task.candidate.guess_rms);
    };
    std::ranges::stable_sort(work, {}, rank);
    for (std::size_t i = 0; i < kept; ++i) state.counts += work[i].counts;
    for (std::size_t i = kept; i < work.size(); ++i) {
      work[i].candidate.shapes.clear();
      work[i].candidate.guess_rms = 0.0;
      Finish(state, work[i]);
    }
  }

  // Finishes all guesses but the nearest that the round still needs.
  void KeepNearest(StagedFitState& state, std::vector<CandidateTask>& settled) {
    const int wanted = CountWanted(options_, state) - SucceededCandidates(state);
    if (Cancelled() || int(settled.size()) <= wanted || settled.front().candidate.is_carried)
      return;
    std::stable_sort(settled.begin(), settled.end(),
                     [](const CandidateTask& a, const CandidateTask& b) {
                       return a.candidate.guess_rms < b.candidate.guess_rms;
                     });
    for (auto it = settled.begin() + wanted; it != settled.end(); ++it) {
      it->candidate.shapes.clear();
      Finish(state, *it);
    }
    settled.resize(wanted);
  }

  // Guesses of one material with different lifts often settle into the same drape.
  static bool RepeatsEarlierDrape(const CandidateTask& work, const StagedFitState& state) {
    return std::any_of(state.candidates.begin(), state.candidates.begin() + work.index,
                       [&](const FitCandidate& before) {
                         return !before.is_carried &&
                                before.guess.table == work.candidate.guess.table &&
                                before.guess.stretch == work.candidate.guess.stretch &&
                                before.guess.bend == work.candidate.guess.bend &&
                                std::abs(before.guess_rms - work.candidate.guess_rms) < kSameRms;
                       });
  }

  void RunSideBySide(
      std::vector<CandidateTask>& work, int round,
      const std::function<void(const CandidateFitter&, CandidateTask&, BatchingBackend&)>& act) {
    RunBatched(*problem_.fine, int(work.size()), kSideBySide, [&](BatchingBackend& task) {
      const CandidateFitter fitter(problem_, options_, task, control_.cancel, round);
      act(fitter, work[task.index()], task);
    });
  }

  void FitOneCandidate(const CandidateFitter& fitter, int round, CandidateTask& work,
                       const std::function<void(double)>& progress) const {
    FitCandidate& candidate = work.candidate;
    const FitCandidate before = candidate;
    if (round == 1 && !problem_.is_pooled) fitter.RetryGuesses(work);
    if (!Cancelled()) fitter.Fit(work, progress);
    if (round > 0 && FindExperiment(problem_) != nullptr)
      for (int pulls = 0; pulls < kMostPulls && fitter.FitNearer(work); ++pulls) continue;
    // The result of an earlier round or part stays if this one fails, or is cancelled before it has
    // one; that of an earlier part also if this one is worse.
    const bool unfitted = !candidate.valid() || (Cancelled() && candidate.cost == before.cost);
    const bool worse = candidate.is_carried && candidate.cost > before.cost;
    if ((round > 0 || before.is_carried) && (unfitted || worse)) candidate = before;
  }

  // Stores a candidate in the state; a cancelled one is not done.
  void Finish(StagedFitState& state, const CandidateTask& work) {
    FitCandidate& candidate = state.candidates[work.index];
    candidate = work.candidate;
    candidate.done = !Cancelled();
    state.iterations += work.iterations;
    state.counts += work.counts;
    for (const std::string& line : work.log) control_.Log(line);
    const int done = DoneCandidates(state), succeeded = SucceededCandidates(state);
    if (done == int(state.candidates.size()) || succeeded == CountWanted(options_, state)) {
      if (state.round == 0) LogStarts(state, succeeded, CountWanted(options_, state));
      for (FitCandidate& each : state.candidates) each.done = false;
      if (LeavesBranchOpen(problem_) && state.parts_done == 0 && state.round == 0)
        KeepFirstFits(state);
      ++state.round;
    }
    state.fit_seconds += Lap();
    Save(state);
  }

  void KeepFirstFits(StagedFitState& state) const {
    constexpr double kExplains = 2.0;  // times the misfit of the best
    const FitCandidate* best = Best(state);
    for (const FitCandidate& each : state.candidates)
      if (best != nullptr && each.valid() && each.profile_rms <= kExplains * best->profile_rms)
        state.first_fits.push_back(FittedMaterial(options_, each));
  }

  void LogStarts(const StagedFitState& state, int count, int wanted) const {
    const bool has_guesses =
        std::any_of(state.candidates.begin(), state.candidates.end(),
                    [](const FitCandidate& candidate) { return !candidate.is_carried; });
    if (has_guesses && count < wanted)
      control_.Log("round 1: " + std::to_string(count) + " starts of " + std::to_string(wanted) +
                   ": the initial guesses have no more drapes of their own");
  }

  // done: of the expected work. rms: the best so far; 0 when not known.
  void Report(const std::string& stage, double done, double rms) const {
    const double fraction = done / work_.total();
    if (rms <= 0) return control_.Report(fraction, stage);
    control_.Report(fraction, stage + Format(", best %.2f %s", rms, MisfitUnit(problem_)));
  }
  void ReportRound(const StagedFitState& state, int round) const {
    const auto begin = work_.rounds.begin();
    const double candidates =
        SucceededCandidates(state) + std::accumulate(shares_.begin(), shares_.end(), 0.0);
    const double done = std::accumulate(begin, begin + round, work_.initial_guesses) +
                        work_.rounds[round] * candidates / CountWanted(options_, state);
    const FitCandidate* best = Best(state);
    Report("round " + std::to_string(round + 1), done, best == nullptr ? 0.0 : best->profile_rms);
  }

  static constexpr double kSameRms = 1e-4;  // [px]
  static constexpr int kMostPulls = 3;      // of a candidate in a round

  const FitProblem& problem_;
  const StagedFitOptions& options_;
  const StagedFitControl& control_;
  const FitWork work_;
  std::chrono::steady_clock::time_point lap_;
  std::vector<double> shares_;  // of the iterations of each candidate in work
};

}  // namespace

double FitWork::total() const {
  return std::accumulate(rounds.begin(), rounds.end(), initial_guesses);
}

FitWork ExpectFitWork(const FitProblem& problem, const StagedFitOptions& options) {
  const auto count = [](const auto& list) { return static_cast<int>(list.size()); };
  const int images = count(problem.observations), threads = problem.fine->threads();
  const InitialGuessOptions grid = options.grid;
  const double coarse_step = ExpectStepTime(problem.coarse->model().mesh.num_vertices(),
                                            problem.fine->model().mesh.num_vertices());
  FitWork work;
  if (!problem.is_pooled)
    work.initial_guesses =
        Elapsed(count(grid.stretch) * count(grid.bend) * count(grid.lifts) * images, threads,
                coarse_step * grid.steps);
  const double settle = options.residuals.rollout.steps + kNewtonSteps;
  const double iteration =
      kEvaluationSteps + kStepsPerParameter * std::stoi(ToString(options.parameters));
  for (int round = 0; round < count(options.candidates_per_round); ++round) {
    const double starts = kPoses * (round == 0   ? kSettledPerStart
                                    : round == 1 ? count(grid.lifts)
                                                 : 0.0);
    work.rounds.push_back(
        Elapsed(options.candidates_per_round[round] * images, threads,
                starts * settle + ExpectIterations(options.iterations[round]) * iteration));
  }
  return work;
}

double ExpectStepTime(int vertices, int of_vertices) {
  return std::pow(double(vertices) / of_vertices, kGrowth);
}

double IterationShare(int iterations, double usual) {
  return 1.0 - std::exp(-2.0 * iterations / usual);
}

void StagedFitOptions::Check() const {
  CheckFields(*this);
  grid.Check();
  CHECK(!candidates_per_round.empty() && candidates_per_round.size() == iterations.size());
}

SettleOptions MakeSettleOptions(const StagedFitOptions& options) {
  constexpr int kGuessNewtonFactor = 2;  // a guess starts further away than a trial
  const ResidualOptions& residuals = options.residuals;
  return {
      .steps = {.h = residuals.rollout.h, .steps = residuals.rollout.steps},
      .solve_mode = residuals.solve_mode,
      .equilibrium = {.max_iterations = kGuessNewtonFactor * residuals.equilibrium.max_iterations}};
}

std::vector<MaterialField> ListStartTables(const FitProblem& problem) {
  std::vector<MaterialField> tables = {problem.material};
  tables.insert(tables.end(), problem.other_materials.begin(), problem.other_materials.end());
  return tables;
}

MaterialField GuessTables(const std::vector<MaterialField>& tables, const InitialGuess& guess) {
  return Scaled(tables.at(guess.table), guess.stretch, guess.bend);
}

const Experiment* FindExperiment(const FitProblem& problem) {
  return problem.observations.empty() ? nullptr : problem.observations.front().experiment.get();
}

FitProblem ForIntervals(FitProblem problem) {
  const auto widen = [](std::shared_ptr<const Experiment>& experiment) {
    if (experiment != nullptr)
      experiment = std::make_shared<const Experiment>(ForIntervals(*experiment));
  };
  for (Observation& each : problem.observations) widen(each.experiment);
  for (SettledExperiment& each : problem.further) widen(each.experiment);
  return problem;
}

bool LeavesBranchOpen(const FitProblem& problem) {
  if (problem.is_pooled) return true;
  const Experiment* experiment = FindExperiment(problem);
  return experiment != nullptr && problem.strips == nullptr && problem.further.empty() &&
         std::ranges::all_of(experiment->measurements, &Measurement::is_contour);
}

bool SeesClothOverSupport(const FitProblem& problem) {
  const auto lies = [](const Experiment* experiment) {
    return experiment != nullptr && SupportRadius(experiment->scene);
  };
  return lies(FindExperiment(problem)) ||
         std::ranges::any_of(problem.further, [&](const SettledExperiment& each) {
           return lies(each.experiment.get());
         });
}

const char* MisfitUnit(const FitProblem& problem) {
  return FindExperiment(problem) == nullptr ? "px" : "sigma";
}

std::vector<RolloutBlock> FurtherBlocks(const FitProblem& problem,
                                        const std::atomic<bool>* cancel) {
  std::vector<RolloutBlock> blocks;
  if (problem.strips != nullptr) blocks = problem.strips->MakeBlocks(cancel);
  for (const SettledExperiment& each : problem.further) {
    RolloutBlock block{.runs = {OwnRun(each.model, each.start, each.backend)},
                       .sights = MakeSights(*each.experiment, *each.model),
                       .equilibrium = {.cancel = cancel},
                       .is_unique = true};
    if (each.experiment->motion) {
      block.solve_mode = SolveMode::kDynamic;
      block.rollout = *each.experiment->motion;
      block.rollout.cancel = cancel;
      // The error of a step is in proportion to its length, so this sum has that of second order.
      block.runs.push_back(OwnRun(each.model, each.start, each.backend));
      block.runs[0].finer = 2;
      block.runs[0].weight = 2.0;
      block.runs[1].weight = -1.0;
      for (Sight& sight : block.sights) sight.readouts.push_back(sight.readouts.front());
      block.prepare = [experiment = each.experiment,
                       fitted = problem.fitted](MaterialField fabric) {
        MaterialField moving = fabric;
        moving.dynamics = experiment->dynamics;
        for (const FreeNumber number : fitted)
          std::ranges::copy(FindNumbers(number, fabric), FindNumbers(number, moving).begin());
        return moving;
      };
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

RolloutResiduals EvaluateFurther(FitProblem problem, const TableParametrisation& fitted,
                                 const std::atomic<bool>* cancel) {
  problem.strips = nullptr;
  RolloutResiduals residuals(&fitted, FurtherBlocks(problem, cancel), {});
  residuals.PrepareForEvaluation(false, true);
  return residuals;
}

std::vector<Observation> LaidObservations(const FitProblem& problem,
                                          const FitCandidate& candidate) {
  std::vector<Observation> observations = problem.observations;
  for (std::size_t i = 0; i < candidate.mirrored.size(); ++i)
    if (candidate.mirrored[i]) observations[i] = observations[i].Mirrored();
  return observations;
}

MaterialField FittedMaterial(const StagedFitOptions& options, const FitCandidate& candidate) {
  return TableParametrisation(candidate.base, options.parameters).Material(candidate.theta);
}

StagedFitState RunStagedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control) {
  options.Check();
  CHECK(!problem.observations.empty());
  return StagedFitter(problem, options, control).Run(std::move(state));
}

int DoneCandidates(const StagedFitState& state) {
  return static_cast<int>(
      std::count_if(state.candidates.begin(), state.candidates.end(),
                    [](const FitCandidate& candidate) { return candidate.done; }));
}

const FitCandidate* Best(const StagedFitState& state) {
  const FitCandidate* best = nullptr;
  for (const FitCandidate& candidate : state.candidates)
    if (candidate.valid() && candidate.termination != FitTermination::kFailed &&
        (best == nullptr || candidate.cost < best->cost))
      best = &candidate;
  return best;
}

}  // namespace drape
