// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/initial_guess.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "losses/outline/outline.h"
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
        MisfitRms(coarse.model(), material, results[i].end.x, observation);
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

// Acceleration of the pull by the displacement that it asks for [s⁻²]: some times the lowest
// eigenvalues of drapes, with which folds move, and little against those of stretch.
constexpr double kPull = 1000.0;
// Shares of the time steps: under the full pull, and while it fades. The rest is free.
constexpr double kPulled = 0.4, kFading = 0.2;

double ComputeAngle(const Eigen::Vector2d& p) { return std::atan2(p.y(), p.x()); }

// From a to b, counter-clockwise, 0 … 2π.
double Turn(double a, double b) { return b >= a ? b - a : b - a + 2 * std::numbers::pi; }

}  // namespace

void InitialGuessOptions::Check() const {
  CheckFields(*this);
  CHECK(!stretch.empty() && !bend.empty() && !lifts.empty());
}

State GuessState(const ClothModel& model, const Observation& observation, double lift) {
  if (observation.experiment != nullptr)
    return MakeStart(*observation.experiment, model, StartNumber(*observation.experiment, lift));
  const std::optional<double> support = SupportRadius(model.scene);
  CHECK(support.has_value()) << "a drape needs a support";
  return {FlapsFromOutline(
              model.mesh, *support,
              VerticalProfile(observation.radius, observation.outline_camera(), observation.discs),
              lift),
          Eigen::VectorXd::Zero(model.num_dofs())};
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
      starts.back().push_back(GuessState(coarse.model(), observation, lift));
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

OutlinePull::OutlinePull(const ClothModel& model, const Observation& observation)
    : model_(model), observation_(observation), hem_(model.mesh.boundary_loops[0]) {
  const Mesh& mesh = model.mesh;
  const std::optional<double> support = SupportRadius(model.scene);
  CHECK(support.has_value()) << "a drape needs a support";
  std::map<double, int> by_angle;
  double reach = *support;
  for (std::size_t i = 0; i < hem_.size(); ++i) {
    by_angle[ComputeAngle(mesh.uv.col(hem_[i]))] = static_cast<int>(i);
    reach = std::max(reach, mesh.uv.col(hem_[i]).norm());
  }
  for (const auto point : mesh.uv.colwise()) {
    const double angle = ComputeAngle(point);
    auto next = by_angle.upper_bound(angle);
    const auto before = next == by_angle.begin() ? std::prev(by_angle.end()) : std::prev(next);
    if (next == by_angle.end()) next = by_angle.begin();
    const double span = Turn(before->first, next->first);
    places_.push_back(
        {.from_support = std::clamp((point.norm() - *support) / (reach - *support), 0.0, 1.0),
         .before = before->second,
         .next = next->second,
         .to_next = span > 0.0 ? std::min(1.0, Turn(before->first, angle) / span) : 0.0});
  }
}

Eigen::Matrix3Xd OutlinePull::HemDisplacement(const Eigen::VectorXd& x) const {
  const Camera camera = observation_.outline_camera();
  const auto angles = static_cast<int>(observation_.radius.size());
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, model_.mesh.num_vertices());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(model_.mesh.num_vertices());
  Outline outline;
  if (OutlineFromMesh(model_.mesh, x, camera, angles, &outline)) {
    const double pixels = camera.pixels_per_metre();
    for (int k = 0; k < angles; ++k) {
      const OutlineHit& hit = outline.hits[k];
      const double error = (observation_.radius[k] - outline.radius[k]) / pixels;
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector3d by_vertex =
            Eigen::Map<const Eigen::Vector3d>(hit.d_radius + 3 * i) / pixels;
        const double w = std::min(1.0, by_vertex.norm());  // more at a grazing ray
        sum.col(hit.vertex[i]) += w * error * by_vertex.stableNormalized();
        weight[hit.vertex[i]] += w;
      }
    }
  }
  Eigen::Matrix3Xd hem = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(hem_.size()));
  for (std::size_t i = 0; i < hem_.size(); ++i)
    if (weight[hem_[i]] > 0.0) hem.col(static_cast<int>(i)) = sum.col(hem_[i]) / weight[hem_[i]];
  return hem;
}

Eigen::VectorXd OutlinePull::Displacement(const Eigen::VectorXd& x) const {
  const Eigen::Matrix3Xd hem = HemDisplacement(x);
  Eigen::VectorXd displacement(x.size());
  for (std::size_t v = 0; v < places_.size(); ++v) {
    const Place& place = places_[v];
    displacement.segment<3>(3 * static_cast<Eigen::Index>(v)) =
        place.from_support *
        ((1.0 - place.to_next) * hem.col(place.before) + place.to_next * hem.col(place.next));
  }
  return displacement;
}

SettledDrape SettleGuided(Backend& backend, const MaterialField& material, const State& start,
                          const Observation& observation, const SettleOptions& options) {
  if (observation.experiment != nullptr)
    return std::move(Settle(backend, material, {&start, 1}, options).front());
  const OutlinePull pull(backend.model(), observation);
  const int pulled = static_cast<int>(kPulled * options.steps.steps);
  const int fading = static_cast<int>(kFading * options.steps.steps);
  RolloutOptions one_step = options.steps;
  one_step.steps = 1;
  State state = start;
  for (int i = 0; i < pulled + fading; ++i) {
    const double share = std::min(1.0, double(pulled + fading - i) / (fading + 1));
    state.v += options.steps.h * kPull * share * pull.Displacement(state.x);
    const RolloutInput input{&material, &state};
    RolloutResult step = std::move(backend.Rollouts({&input, 1}, one_step, nullptr).front());
    if (step.status != RolloutStatus::kOk) return {.steps = step.status, .rest = {}};
    state = std::move(step.end);
  }
  SettleOptions free = options;
  free.steps.steps -= pulled + fading;
  state.v.setZero();
  return std::move(Settle(backend, material, {&state, 1}, free).front());
}

}  // namespace drape
