// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_tool.h"

#include <utility>

#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/studies/optimisers/optimisers_report.h"

namespace drape {
namespace {

std::vector<Option> ImageOptions(OptimiserBenchmarkOptions& options) {
  return {
      {.key = "twins",
       .value = &options.twins,
       .doc = "material files whose synthetic silhouettes are fitted",
       .is_path = true},
      MeshOption("twin_mesh", &options.twin_mesh, "mesh of the synthetic drapes"),
      {.key = "twin_seed",
       .value = &options.twin_seed,
       .doc = "random seed of the first synthetic drape's start; the others use the following ones",
       .least = 0,
       .most = 1000000000},
      {.key = "twin_hem_rms",
       .value = &options.twin_hem_rms,
       .doc = "root mean square height of these starts at the hem",
       .unit = "m",
       .least = 0,
       .most = 0.05,
       .above_least = true},
      {.key = "material",
       .value = &options.material,
       .doc = "start tables of the fits to synthetic silhouettes",
       .is_path = true},
      {.key = "images",
       .value = &options.images,
       .doc = "real silhouettes, one problem each: files, folders, patterns",
       .is_path = true},
      {.key = "image_materials",
       .value = &options.image_materials,
       .doc =
           "start tables of the fits to real silhouettes: one file for all or one per silhouette",
       .is_path = true},
  };
}

std::vector<Option> StartTableOptions(OptimiserBenchmarkOptions& options) {
  FitSpec& spec = options.spec;
  return {
      {.key = "min_relative_stiffness",
       .value = &spec.min_relative_stiffness,
       .doc = "smallest start entry relative to the largest of its column; smaller ones are raised "
              "to it",
       .least = 0,
       .most = 1},
      BaseOption(options.base),
  };
}

std::vector<Option> FittingOptions(OptimiserBenchmarkOptions& options) {
  FitSpec& spec = options.spec;
  return {
      MeshOption("mesh", &options.mesh, "mesh of the fits"),
      MeshOption("coarse_mesh", &options.coarse_mesh, "mesh of the initial-guess grid"),
      LawOption(spec.law),
      {.key = "num_parameters",
       .value = &options.parameters,
       .doc = "numbers of free parameters, each giving one problem per image: 1, 2, 3, 7, 39",
       .least = 1,
       .most = 39},
      {.key = "sigma_px",
       .value = &spec.stages.residuals.sigma_px,
       .doc = "standard deviation of the outline",
       .unit = "px",
       .least = 1e-4,
       .most = 1e4},
      {.key = "prior_sigma",
       .value = &spec.stages.prior_sigma,
       .doc = "prior standard deviation of each log factor",
       .least = 1e-9,
       .most = 1e4},
  };
}

std::vector<Option> MethodOptions(OptimiserBenchmarkOptions& options) {
  OptimiserOptions& optimiser = options.optimiser;
  return {
      {.key = "methods",
       .value = &options.methods,
       .doc = "methods among lm, lm_patient, dogleg, subspace_dogleg, lbfgs, adam_published, "
              "adam_0.03, adam_0.1 and, with NLopt, bobyqa, sbplx, crs, direct (none: all of "
              "these); cmaes, bo, rembo_2, rembo_4, rembo_8, rembo_ucb_4, hesbo_2, hesbo_4, "
              "hesbo_8; a method from bobyqa on followed by _lm ends with 20 rounds of lm"},
      {.key = "budget",
       .value = &optimiser.budget,
       .doc = "budget of each run in rollouts",
       .least = 1,
       .most = 1e6},
      {.key = "jacobian_cost_units",
       .value = &optimiser.jacobian_cost_units,
       .doc = "cost of a Jacobian in rollouts, beside its own rollout",
       .least = 0,
       .most = 1000},
      {.key = "bound",
       .value = &optimiser.bound,
       .doc = "largest log factor for the methods without derivatives",
       .least = 0,
       .most = 20,
       .above_least = true},
      {.key = "failed_cost_factor",
       .value = &optimiser.failed_cost_factor,
       .doc = "cost that the methods of NLopt see where no drape is found, relative to the start",
       .least = 1,
       .most = 1e6,
       .above_least = true},
  };
}

std::vector<Option> RunOptions(OptimiserBenchmarkOptions& options) {
  return {
      {.key = "method_seed",
       .value = &options.optimiser.seed,
       .doc = "first random seed of the stochastic methods",
       .least = 0,
       .most = 1000000000},
      {.key = "num_seeds",
       .value = &options.seeds,
       .doc = "runs of each stochastic method, with this and the following seeds",
       .least = 1,
       .most = 1000},
      {.key = "checkpoints",
       .value = &options.checkpoints,
       .doc = "budgets at which tables also report the costs, where they are below the budget",
       .least = 1,
       .most = 1e6},
      {.key = "branch_tolerance",
       .value = &options.branch_tolerance,
       .doc = "largest root mean square distance of the vertices of two drapes on the same branch",
       .unit = "m",
       .least = 0,
       .most = 1,
       .above_least = true},
      BackendOption(options.spec.backend),
      ThreadsOption(options.spec.threads),
      OutOption(options.out),
  };
}

// With the base of the materials that need one.
OptimiserBenchmarkOptions WithBases(OptimiserBenchmarkOptions options) {
  std::vector<std::string*> materials = {&options.material};
  for (std::string& twin : options.twins) materials.push_back(&twin);
  for (std::string& start : options.image_materials) materials.push_back(&start);
  ApplyBase(options.base, materials);
  return options;
}

}  // namespace

OptionTable OptimiserBenchmarkTable(OptimiserBenchmarkOptions& options) {
  return {.tool = "drape_compare_optimisers",
          .summary = "compares optimisers with the same cost, start and budget on many silhouettes",
          .example =
              "drape_compare_optimisers --config=configs/studies/compare_optimisers.json "
              "--out=out/optimisers",
          .notes =
              "files: summary.json, report.md, traces.csv, convergence.png, profiles.png, "
              "data_profiles.png, quartiles.png and branches.png. They replace the files of an "
              "earlier run together, at the end. twins/ "
              "and runs/: an interrupted run continues from them.\n"
              "exit code 3: no problem has a start\n"
              "Ctrl-C keeps the finished runs.\n",
          .options = Concatenate(
              Grouped("problems",
                      Concatenate(ImageOptions(options), Concatenate(StartTableOptions(options),
                                                                     FittingOptions(options)))),
              Grouped("camera of the images", CameraOptions(options.spec.observation.camera)),
              Grouped("methods and results",
                      Concatenate(MethodOptions(options),
                                  Concatenate(RunOptions(options), CellOptions(options.cells)))))};
}

std::string ListOptimiserText(const OptimiserBenchmarkOptions& options) {
  return ListText(ListOptimiserCells(WithBases(options)), options.cells.ParseShare());
}

OptimiserBenchmark RunBenchmarkTool(OptimiserBenchmarkOptions options, const RunControl& control) {
  options = WithBases(std::move(options));
  options.spec.threads = CountThreads(options.spec.threads);
  const bool is_share = options.cells.ParseShare().has_value();
  const OutputFolder out(options.out,
                         {"summary.json", "report.md", "traces.csv", "convergence.png",
                          "profiles.png", "data_profiles.png", "quartiles.png", "branches.png"},
                         is_share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  OptimiserBenchmark benchmark = RunOptimiserBenchmark(options, control);
  if (benchmark.problems.empty()) return benchmark;
  WriteBenchmarkReport(options, out, &benchmark);
  out.Publish();
  return benchmark;
}

namespace {

ToolOutcome Run(const OptimiserBenchmarkOptions& options, const RunControl& control) {
  if (options.cells.list) return {.text = ListOptimiserText(options)};
  const OptimiserBenchmark benchmark = RunBenchmarkTool(options, control);
  std::string text;
  for (const std::string& note : benchmark.notes) text += note + "\n";
  if (!options.cells.share.empty())
    return {.text = text + ShareText(options.cells.share, benchmark.done, benchmark.cells),
            .cancelled = benchmark.cancelled};
  const bool has_problems = !benchmark.problems.empty();
  if (has_problems) text += MakeMethodTable(benchmark, options.branch_tolerance).Aligned();
  return {.text = std::move(text),
          .cancelled = benchmark.cancelled,
          .failure = has_problems ? "" : "no problem has a start"};
}

}  // namespace

int CompareOptimisersMain(int argc, char** argv) {
  return ToolMain(argc, argv, OptimiserBenchmarkTable, Run);
}

}  // namespace drape
