// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/initial_guess_grid.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "losses/outline/shape_features.h"
#include "physics/cloth/start_shape.h"
#include "solver/forward/batching_backend.h"

namespace drape {
namespace {

// In one batch, with all lifts: many for a GPU's sake, few for the progress line's.
constexpr int kMaterialsAtATime = 16;

struct Trial {
  double lift = 0.0;
  double profile_rms = 0.0;  // [px]
};

// The trials of one target under one material that ended well, best first.
std::vector<Trial> RankLifts(Backend& coarse, const MaterialField& material,
                             const Observation& target, const std::vector<State>& seeds,
                             const InitialGuessOptions& options, const std::atomic<bool>* cancel) {
  std::vector<RolloutInput> inputs;
  for (const State& seed : seeds) inputs.push_back({&material, &seed});
  RolloutOptions rollout;
  rollout.h = options.h;
  rollout.steps = options.steps;
  rollout.cancel = cancel;
  const std::vector<RolloutResult> results = coarse.Rollouts(inputs, rollout, nullptr);
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < results.size(); ++i) {
    Outline outline;
    if (results[i].status != RolloutStatus::kOk ||
        !OutlineFromMesh(coarse.model().mesh, results[i].end.x, target.camera,
                         static_cast<int>(target.radius.size()), &outline)) {
      continue;
    }
    trials.push_back({options.lifts[i], ProfileRms(outline.radius, target.radius)});
  }
  std::stable_sort(trials.begin(), trials.end(),
                   [](const Trial& a, const Trial& b) { return a.profile_rms < b.profile_rms; });
  return trials;
}

// The j-th best lift of each target together, while each target has one.
std::vector<InitialGuess> Combine(double stretch, double bend,
                                  const std::vector<std::vector<Trial>>& by_target) {
  std::size_t count = by_target.front().size();
  for (const auto& trials : by_target) count = std::min(count, trials.size());
  std::vector<InitialGuess> candidates;
  for (std::size_t j = 0; j < count; ++j) {
    InitialGuess candidate{stretch, bend, {}, 0.0};
    double sum = 0.0;
    for (const auto& trials : by_target) {
      candidate.lifts.push_back(trials[j].lift);
      sum += trials[j].profile_rms * trials[j].profile_rms;
    }
    candidate.profile_rms = std::sqrt(sum / static_cast<double>(by_target.size()));
    candidates.push_back(candidate);
  }
  return candidates;
}

std::vector<double> WithMeans(const std::vector<double>& factors) {
  std::vector<double> finer = {factors.front()};
  for (std::size_t i = 1; i < factors.size(); ++i) {
    finer.push_back(std::sqrt(factors[i - 1] * factors[i]));
    finer.push_back(factors[i]);
  }
  return finer;
}

}  // namespace

InitialGuessOptions Refined(InitialGuessOptions grid, int materials) {
  std::vector<double>& factors = grid.bend.size() > 1 ? grid.bend : grid.stretch;
  while (factors.size() > 1 && int(grid.stretch.size() * grid.bend.size()) < materials)
    factors = WithMeans(factors);
  return grid;
}

void InitialGuessOptions::Check() const {
  CHECK_GT(h, 0.0);
  CHECK_GE(steps, 0);
  CHECK(!stretch.empty() && !bend.empty() && !lifts.empty());
  for (const double factor : stretch) CHECK_GT(factor, 0.0);
  for (const double factor : bend) CHECK_GT(factor, 0.0);
  for (const double lift : lifts) CHECK(lift > 0.0 && lift <= 1.0) << lift;
}

State GuessState(const ClothModel& model, const Observation& target, double lift) {
  const std::optional<double> support = SupportRadius(model.scene);
  CHECK(support.has_value()) << "a drape needs a support";
  return {
      FlapsFromOutline(model.mesh, *support, MetresFromPixels(target.radius, target.camera), lift),
      Eigen::VectorXd::Zero(model.num_dofs())};
}

std::vector<InitialGuess> RankInitialGuesses(Backend& coarse, const MaterialField& material,
                                             const std::vector<Observation>& targets,
                                             const InitialGuessOptions& options,
                                             const std::atomic<bool>* cancel,
                                             const std::function<void(double)>& progress) {
  options.Check();
  std::vector<std::vector<State>> seeds;
  for (const Observation& target : targets) {
    seeds.emplace_back();
    for (const double lift : options.lifts)
      seeds.back().push_back(GuessState(coarse.model(), target, lift));
  }
  const int count = static_cast<int>(options.stretch.size() * options.bend.size());
  std::vector<std::vector<InitialGuess>> found(count);
  int done = 0;
  RunBatched(coarse, count, kMaterialsAtATime, [&](BatchingBackend& task) {
    if (cancel != nullptr && cancel->load()) return;
    const double stretch = options.stretch[task.index() / options.bend.size()];
    const double bend = options.bend[task.index() % options.bend.size()];
    const MaterialField scaled = Scaled(material, stretch, bend);
    std::vector<std::vector<Trial>> by_target;
    for (std::size_t i = 0; i < targets.size(); ++i)
      by_target.push_back(RankLifts(task, scaled, targets[i], seeds[i], options, cancel));
    found[task.index()] = Combine(stretch, bend, by_target);
    if (progress) task.RunSerially([&] { progress(++done / double(count)); });
  });
  std::vector<InitialGuess> ranked;
  for (const auto& candidates : found)
    ranked.insert(ranked.end(), candidates.begin(), candidates.end());
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.profile_rms < b.profile_rms; });
  return ranked;
}

}  // namespace drape
