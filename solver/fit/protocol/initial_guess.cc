// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/initial_guess.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "physics/cloth/state.h"
#include "solver/fit/rollout_residuals.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// One batch, with all lifts: many keep a GPU busy, few keep the progress line up to date.
constexpr int kMaterialsAtATime = 16;

struct Trial {
  double lift = 0.0;
  double profile_rms = 0.0;  // [px]
};

// The trials of one observation under one material that ended well, best first.
std::vector<Trial> RankLifts(Backend& coarse, const MaterialField& material,
                             const Observation& observation, const std::vector<State>& starts,
                             const InitialGuessOptions& options, const std::atomic<bool>* cancel) {
  const std::vector<RolloutResult> results =
      coarse.Rollouts(MakeInputs(material, starts),
                      {.h = options.time_step, .steps = options.steps, .cancel = cancel}, nullptr);
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].status != RolloutStatus::kOk) continue;
    const std::optional<double> rms =
        Misfit(*observation.Measured(), coarse.model(), material, results[i].end.x);
    if (rms) trials.push_back({options.lifts[i], *rms});
  }
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& a, const Trial& b) { return a.profile_rms < b.profile_rms; });
  return trials;
}

// The j-th best lift of each observation together, while each observation has one.
std::vector<InitialGuess> Combine(int table, double stretch, double bend,
                                  const std::vector<std::vector<Trial>>& by_observation) {
  std::size_t count = by_observation.front().size();
  for (const auto& trials : by_observation) count = std::min(count, trials.size());
  std::vector<InitialGuess> guesses;
  for (std::size_t j = 0; j < count; ++j) {
    InitialGuess guess{table, stretch, bend, {}, 0.0};
    double sum = 0.0;
    for (const auto& trials : by_observation) {
      guess.lifts.push_back(trials[j].lift);
      sum += trials[j].profile_rms * trials[j].profile_rms;
    }
    guess.profile_rms = std::sqrt(sum / static_cast<double>(by_observation.size()));
    guesses.push_back(guess);
  }
  return guesses;
}

// The guesses of one scale of one table, by their number.
std::vector<InitialGuess> TryScale(Backend& coarse, const std::vector<MaterialField>& tables,
                                   const std::vector<Observation>& observations,
                                   const std::vector<std::vector<State>>& starts,
                                   const InitialGuessOptions& options, int number,
                                   const std::atomic<bool>* cancel) {
  const int table = number / options.num_scales(), scale = number % options.num_scales();
  const double stretch = options.stretch[scale / options.bend.size()];
  const double bend = options.bend[scale % options.bend.size()];
  const MaterialField scaled = Scaled(tables[table], stretch, bend);
  std::vector<std::vector<Trial>> by_observation;
  for (std::size_t i = 0; i < observations.size(); ++i)
    by_observation.push_back(
        RankLifts(coarse, scaled, observations[i], starts[i], options, cancel));
  return Combine(table, stretch, bend, by_observation);
}

}  // namespace

void InitialGuessOptions::Check() const {
  CheckFields(*this);
  CHECK(!stretch.empty() && !bend.empty() && !lifts.empty());
}

void TryInitialGuesses(Backend& coarse, const std::vector<MaterialField>& tables,
                       const std::vector<Observation>& observations,
                       const InitialGuessOptions& options, const RunControl& control,
                       TriedGuesses& tried, const std::function<void()>& save) {
  options.Check();
  std::vector<std::vector<State>> starts;
  for (const Observation& observation : observations) {
    starts.emplace_back();
    for (const double lift : options.lifts)
      starts.back().push_back(StartAt(*observation.Measured(), coarse.model(), lift));
  }
  const int count = static_cast<int>(tables.size()) * options.num_scales();
  while (static_cast<int>(tried.size()) < count) {
    const int first = static_cast<int>(tried.size());
    TriedGuesses found(std::min(count - first, kMaterialsAtATime));
    int done = first;
    RunBatched(coarse, static_cast<int>(found.size()), kMaterialsAtATime,
               [&](BatchingBackend& task) {
                 if (control.cancelled()) return;
                 found[task.index()] = TryScale(task, tables, observations, starts, options,
                                                first + task.index(), control.cancel);
                 task.RunSerially([&] { control.Report(++done / double(count), ""); });
               });
    if (control.cancelled()) return;
    tried.insert(tried.end(), found.begin(), found.end());
    if (static_cast<int>(tried.size()) < count) save();
  }
}

std::vector<InitialGuess> RankGuesses(const TriedGuesses& tried) {
  std::vector<InitialGuess> ranked;
  for (const auto& guesses : tried) ranked.insert(ranked.end(), guesses.begin(), guesses.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.profile_rms < b.profile_rms; });
  return ranked;
}

}  // namespace drape
