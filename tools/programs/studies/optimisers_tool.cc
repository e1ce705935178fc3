// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <utility>

#include "solver/studies/optimisers/optimiser_study.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

std::vector<Option> ProblemOptions(OptimiserStudyOptions& options) {
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
      FabricOption(&options.material),
      {.key = "images",
       .value = &options.images,
       .doc = "real silhouettes, one problem each: files, folders, patterns",
       .is_path = true},
      {.key = "image_fabrics",
       .value = &options.image_materials,
       .doc =
           "start tables of the fits to real silhouettes: one file for all or one per silhouette",
       .is_path = true},
      {.key = "min_relative_stiffness",
       .value = &options.spec.min_relative_stiffness,
       .doc = "smallest start entry relative to the largest of its column; smaller ones are raised "
              "to it",
       .least = 0,
       .most = 1},
      MeshOption("mesh", &options.mesh, "mesh of the fits"),
      MeshOption("coarse_mesh", &options.coarse_mesh, "mesh of the initial-guess grid"),
      {.key = "num_parameters",
       .value = &options.parameters,
       .doc = "numbers of free parameters, each giving one problem per image: 1, 2, 3, 7, 39",
       .least = 1,
       .most = 39},
  };
}

std::vector<Option> MethodOptions(OptimiserStudyOptions& options) {
  OptimiserOptions& optimiser = options.optimiser;
  return {
      {.key = "methods",
       .value = &options.methods,
       .doc =
           "methods among lm, lm_patient, dogleg, subspace_dogleg, lbfgs, adam_published, "
           "adam_0.03, adam_0.1, bobyqa, sbplx, crs, direct (none: all of these) and, with "
           "python3-scipy, cmaes, bo, rembo_2, rembo_4, rembo_8, rembo_ucb_4, hesbo_2, "
           "hesbo_4, hesbo_8; a method from bobyqa on followed by _lm ends with 20 rounds of lm"},
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
      {.key = "num_seeds",
       .value = &options.seeds,
       .doc = "runs of each stochastic method, with random seeds from 1",
       .least = 1,
       .most = 1000},
      {.key = "checkpoints",
       .value = &options.checkpoints,
       .doc = "budgets at which tables also report the costs, where they are below the budget",
       .least = 1,
       .most = 1e6},
      BackendOption(options.spec.backend),
      ThreadsOption(options.spec.threads),
  };
}

OptionTable OptimiserStudyTable(OptimiserStudyOptions& options) {
  return {
      .tool = "drape_compare_optimisers",
      .summary = "compares optimisers with the same cost, start and budget on many silhouettes",
      .example =
          "drape_compare_optimisers --config=configs/studies/compare_optimisers.json "
          "--out=out/optimisers",
      .notes =
          "files: compare_optimisers.json, report.md, traces.csv, and as .svg and .png "
          "convergence, profiles and branches; twins/ has the silhouettes that are fitted, cells/ "
          "the finished runs, from which the same command continues\n"
          "exit code 3: no problem has a start\n",
      .options = Concatenate(
          Grouped("problems", ProblemOptions(options)),
          Grouped("methods and results",
                  Concatenate(MethodOptions(options), StudyOptionList(options.study))))};
}

ToolOutcome RunOptimisers(const OptimiserStudyOptions& given, const RunControl& control) {
  OptimiserStudyOptions options = given;
  options.study.threads = options.spec.threads = CountThreads(options.spec.threads);
  options.optimiser.search_command = StudyScriptCommand("search");
  const Study study = MakeOptimiserStudy(options);
  bool has_problems = options.study.list || !options.study.share.empty();
  const auto summarise = [&](const StudyResult& result) {
    for (const auto& cell : result.results)
      has_problems = has_problems || (cell && !cell->contains("failure"));
    nlohmann::ordered_json json = SummariseCells(study, result);
    json["checkpoints"] = options.checkpoints;
    return json;
  };
  ToolOutcome outcome = RunStudyProgram(study, options.study, control, summarise);
  if (!has_problems && !outcome.cancelled) outcome.failure = "no problem has a start";
  return outcome;
}

}  // namespace

int CompareOptimisersMain(int argc, char** argv) {
  return ToolMain(argc, argv, OptimiserStudyTable, RunOptimisers);
}

}  // namespace drape
