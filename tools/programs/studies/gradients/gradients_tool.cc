// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/gradients/gradients_tool.h"

#include "losses/outline/shape_features.h"
#include "physics/cloth/start_shape.h"
#include "physics/util/random.h"
#include "tools/cli/output_folder.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/studies/gradients/gradients_report.h"

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

SceneInput MakeInput(const GradientsOptions& options, const std::string& law) {
  SceneInput input;
  input.mesh = options.mesh;
  input.material = options.material;
  input.law = law;
  return input;
}

class Study {
 public:
  Study(const GradientsOptions& options, const RunControl& control)
      : options_(options), control_(control) {
    for (const char* law : {"smooth", "reference"}) {
      scenes_.push_back(LoadScene(MakeInput(options, law)));
      backends_.push_back(MakeCpuBackend(scenes_.back().model, 1));
    }
  }

  GradientStudy Run() {
    for (int law = 0; law < 2; ++law) Sweep(law);
    for (int law = 0; law < 2; ++law)
      for (const double h : options_.time_steps) Horizons(law, h);
    for (int i = 0; i < options_.fold_starts; ++i) Follow(options_.start_seed + i);
    study_.cancelled = Cancelled();
    return std::move(study_);
  }

 private:
  bool Cancelled() const { return control_.cancelled(); }
  const char* MakeLawFor(int law) const { return law == 0 ? "smooth" : "reference"; }
  // False once cancelled.
  bool Begin(const std::string& note) {
    const double parts = 2.0 + 2.0 * double(options_.time_steps.size()) + options_.fold_starts;
    control_.Report(done_++ / parts, note);
    return !Cancelled();
  }
  TableParametrisation MakeLine(int law) const {
    return {scenes_[law].material.field, MakeDirection(options_.direction_seed)};
  }
  State StartCost(const ClothModel& model, int seed) const {
    State start = model.RestState();
    start.x = ApplyStartShape(model.mesh, kSupportRadius,
                              RandomStartShape(static_cast<uint64_t>(seed), options_.hem_rms));
    return start;
  }

  void Sweep(int law) {
    if (!Begin(std::string("difference steps, ") + MakeLawFor(law))) return;
    const State start = StartCost(*scenes_[law].model, options_.start_seed);
    const RolloutOptions rollout = {.h = kSweepH, .steps = options_.sweep_horizon};
    const TableParametrisation line = MakeLine(law);
    study_.sweeps.push_back(
        {std::string(MakeLawFor(law)) + ", " + std::to_string(options_.sweep_horizon) + " steps",
         CompareDifferences(*backends_[law], line, start, SolveMode::kDynamic, rollout, kSteps)});
    const RolloutInput input{&scenes_[law].material.field, &start};
    const RolloutResult fallen =
        backends_[law]->Rollouts({&input, 1}, {.h = kSweepH}, nullptr).front();
    study_.sweeps.push_back({std::string(MakeLawFor(law)) + ", at rest",
                             CompareDifferences(*backends_[law], line, fallen.end,
                                                SolveMode::kStatic, rollout, kSteps)});
  }

  void Horizons(int law, double h) {
    HorizonSeries series{MakeLawFor(law), h, {}, {}};
    if (!Begin("horizons, " + series.law)) return;
    const State start = StartCost(*scenes_[law].model, options_.start_seed);
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
    const LoadedScene& scene = scenes_.front();
    const State start = StartCost(*scene.model, seed);
    const RolloutInput input{&scene.material.field, &start};
    const RolloutResult fallen =
        backends_.front()->Rollouts({&input, 1}, {.h = kSweepH}, nullptr).front();
    StepSolver solver(scene.model);
    ContinuationOptions options;
    options.end = kFoldEnd;
    options.min_step = kShortest;
    options.corrector.cancel = control_.cancel;
    FollowedBranch branch{
        seed,
        FollowBranch(solver, TableParametrisation(scene.material.field, ParameterTying::kScales),
                     Eigen::Vector2d(0.0, 1.0), fallen.end.x, options),
        {}};
    branch.approach = FindFoldApproach(branch.path, kFoldRange);
    study_.branches.push_back(std::move(branch));
  }

  const GradientsOptions& options_;
  const RunControl& control_;
  std::vector<LoadedScene> scenes_;  // smooth, reference
  std::vector<std::unique_ptr<Backend>> backends_;
  GradientStudy study_;
  int done_ = 0;
};

}  // namespace

OptionTable GradientsTable(GradientsOptions& options) {
  return {.tool = "drape_gradients",
          .summary = "where gradients of a drape fail: differences, horizons, kinks, folds",
          .example = "drape_gradients --config=configs/studies/gradients.json --out=out/gradients",
          .notes =
              "files: summary.json, report.md, differences.png, horizons.png, fold.png\n"
              "Ctrl-C writes what there is\n",
          .options = {MeshOption("mesh", &options.mesh, "cloth"),
                      {.key = "material",
                       .value = &options.material,
                       .doc = "fabric",
                       .is_path = true,
                       .required = true},
                      {.key = "start_seed",
                       .value = &options.start_seed,
                       .doc = "of the random start",
                       .least = 0,
                       .most = 1000000000},
                      {.key = "hem_rms",
                       .value = &options.hem_rms,
                       .doc = "size of the start at the hem, root mean square",
                       .unit = "m",
                       .least = 0,
                       .most = 0.05,
                       .above_least = true},
                      {.key = "direction_seed",
                       .value = &options.direction_seed,
                       .doc = "of the direction in the 39 log entries",
                       .least = 0,
                       .most = 1000000000},
                      {.key = "horizons",
                       .value = &options.horizons,
                       .doc = "counts of steps",
                       .least = 1,
                       .most = 100000},
                      {.key = "time_steps",
                       .value = &options.time_steps,
                       .doc = "time steps",
                       .unit = "s",
                       .least = 0,
                       .most = 10,
                       .above_least = true},
                      {.key = "horizon_step",
                       .value = &options.horizon_step,
                       .doc = "step of the differences at each horizon, in log units",
                       .least = 0,
                       .most = 1,
                       .above_least = true},
                      {.key = "sweep_horizon",
                       .value = &options.sweep_horizon,
                       .doc = "steps of 0.1 s, where the step of the differences is swept",
                       .least = 1,
                       .most = 100000},
                      {.key = "fold_starts",
                       .value = &options.fold_starts,
                       .doc = "branches followed to softer bend until they end, from start_seed on",
                       .least = 0,
                       .most = 1000},
                      OutOption(options.out)}};
}

GradientStudy StudyGradients(const GradientsOptions& options, const RunControl& control) {
  Study study(options, control);
  const OutputFolder out(options.out);
  GradientStudy found = study.Run();
  WriteGradientReport(found, out);
  out.Publish();
  return found;
}

}  // namespace drape
