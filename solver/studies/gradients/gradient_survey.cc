// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/gradients/gradient_survey.h"

#include <random>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/outline/shape_features.h"
#include "physics/cloth/start_shape.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr double kSteps[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
constexpr double kSweepH = 0.1;      // [s]
constexpr double kFoldRange = 10.0;  // of the speed, for the fitted exponents
constexpr double kFoldEnd = -3.0;    // of the log factor on all bend entries
constexpr double kShortest = 1e-7;   // of a step towards the fold

// A unit vector of the 39 log entries.
Eigen::MatrixXd MakeDirection(int seed) {
  std::mt19937_64 random(static_cast<uint64_t>(seed));
  Eigen::MatrixXd direction(kMaterialEntries, 1);
  for (double& entry : direction.reshaped()) entry = SampleNormal(random);
  return direction / direction.norm();
}

class Study {
 public:
  Study(std::span<const StudiedCloth> cloths, const GradientSurveyOptions& options,
        const RunControl& control)
      : cloths_(cloths), options_(options), control_(control) {
    for (const StudiedCloth& cloth : cloths)
      backends_.push_back(MakeBackend(options.backend, cloth.model, 1));
  }

  GradientStudy Run() {
    const int laws = static_cast<int>(cloths_.size());
    for (int law = 0; law < laws; ++law) Sweep(law);
    for (int law = 0; law < laws; ++law)
      for (const double h : options_.time_steps) Horizons(law, h);
    for (int i = 0; i < options_.fold_starts; ++i) Follow(options_.start_seed + i);
    study_.cancelled = Cancelled();
    return std::move(study_);
  }

 private:
  bool Cancelled() const { return control_.cancelled(); }
  // False once cancelled.
  bool Begin(const std::string& note) {
    const double parts =
        double(cloths_.size() * (1 + options_.time_steps.size())) + options_.fold_starts;
    control_.Report(done_++ / parts, note);
    return !Cancelled();
  }
  TableParametrisation MakeLine(int law) const {
    return {cloths_[law].material, MakeDirection(options_.direction_seed)};
  }
  State MakeStart(const ClothModel& model, int seed) const {
    State start = model.RestState();
    start.x = ApplyStartShape(model.mesh, DrapeDiscs().support,
                              RandomStartShape(static_cast<uint64_t>(seed), options_.hem_rms));
    return start;
  }

  void Sweep(int law) {
    if (!Begin("difference steps, " + cloths_[law].law)) return;
    const State start = MakeStart(*cloths_[law].model, options_.start_seed);
    const RolloutOptions rollout = {.h = kSweepH, .steps = options_.sweep_horizon};
    const TableParametrisation line = MakeLine(law);
    study_.sweeps.push_back(
        {cloths_[law].law + ", " + std::to_string(options_.sweep_horizon) + " steps",
         CompareDifferences(*backends_[law], line, start, SolveMode::kDynamic, rollout, kSteps)});
    const RolloutInput input{&cloths_[law].material, &start};
    const RolloutResult relaxed =
        backends_[law]->Rollouts({&input, 1}, {.h = kSweepH}, nullptr).front();
    study_.sweeps.push_back(
        {cloths_[law].law + ", at rest", CompareDifferences(*backends_[law], line, relaxed.end,
                                                            SolveMode::kStatic, rollout, kSteps)});
  }

  void Horizons(int law, double h) {
    HorizonSeries series{cloths_[law].law, h, {}, {}};
    if (!Begin("horizons, " + series.law)) return;
    const State start = MakeStart(*cloths_[law].model, options_.start_seed);
    for (const int horizon : options_.horizons) {
      if (Cancelled()) break;
      const std::vector<GradientError> errors =
          CompareDifferences(*backends_[law], MakeLine(law), start, SolveMode::kDynamic,
                             {.h = h, .steps = horizon}, {&options_.horizon_step, 1});
      if (errors.empty()) continue;
      series.horizons.push_back(horizon);
      series.errors.push_back(errors.front());
    }
    study_.horizons.push_back(std::move(series));
  }

  void Follow(int seed) {
    if (!Begin("branch of start " + std::to_string(seed))) return;
    const StudiedCloth& cloth = cloths_.front();
    const State start = MakeStart(*cloth.model, seed);
    const RolloutInput input{&cloth.material, &start};
    const RolloutResult relaxed =
        backends_.front()->Rollouts({&input, 1}, {.h = kSweepH}, nullptr).front();
    StepSolver solver(cloth.model);
    ContinuationOptions options;
    options.end = kFoldEnd;
    options.min_step = kShortest;
    options.corrector.cancel = control_.cancel;
    FollowedBranch branch{
        seed,
        FollowBranch(solver, TableParametrisation(cloth.material, ParameterTying::kScales),
                     Eigen::Vector2d(0.0, 1.0), relaxed.end.x, options),
        {}};
    branch.approach = FindFoldApproach(branch.path, kFoldRange);
    study_.branches.push_back(std::move(branch));
  }

  std::span<const StudiedCloth> cloths_;
  const GradientSurveyOptions& options_;
  const RunControl& control_;
  std::vector<std::unique_ptr<Backend>> backends_;
  GradientStudy study_;
  int done_ = 0;
};

}  // namespace

GradientStudy SurveyGradients(std::span<const StudiedCloth> cloths,
                              const GradientSurveyOptions& options, const RunControl& control) {
  return Study(cloths, options, control).Run();
}

}  // namespace drape
