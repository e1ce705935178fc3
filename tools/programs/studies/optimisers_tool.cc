// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <utility>

#include "solver/studies/optimisers/optimiser_study.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

std::vector<Option> ProblemOptions(OptimiserStudyOptions& options) {
  return {
      PathOption("twins", &options.twins, "material files whose synthetic silhouettes are fitted"),
      MeshOption("twin_mesh", &options.twin_mesh, "mesh of the synthetic drapes"),
      NumberOption(
          "twin_seed", &options.twin_seed, 0, 1000000000,
          "random seed of the first synthetic drape's start; the others use the following ones"),
      FabricOption(&options.material),
      PathOption("images", &options.images,
                 "real silhouettes, one problem each: files, folders, patterns"),
      PathOption(
          "image_fabrics", &options.image_materials,
          "start tables of the fits to real silhouettes: one file for all or one per silhouette"),
      NumberOption(
          "min_relative_stiffness", &options.spec.min_relative_stiffness, 0, 1,
          "smallest start entry relative to the largest of its column; smaller ones are raised "
          "to it"),
      MeshOption("mesh", &options.mesh, "mesh of the fits"),
      MeshOption("coarse_mesh", &options.coarse_mesh, "mesh of the initial-guess grid"),
      NumberOption("num_parameters", &options.parameters, 1, 39,
                   "numbers of free parameters, each giving one problem per image: 1, 2, 3, 7, 39"),
  };
}

std::vector<Option> MethodOptions(OptimiserStudyOptions& options) {
  OptimiserOptions& optimiser = options.optimiser;
  return {
      PlainOption(
          "methods", &options.methods,
          "methods among lm, lm_patient, dogleg, subspace_dogleg, lbfgs, adam_published, "
          "adam_0.03, adam_0.1, bobyqa, sbplx, crs, direct (none: all of these) and, with "
          "python3-scipy, cmaes, bo, rembo_2, rembo_4, rembo_8, rembo_ucb_4, hesbo_2, "
          "hesbo_4, hesbo_8; a method from bobyqa on followed by _lm ends with 20 rounds of lm"),
      NumberOption("budget", &optimiser.budget, 1, 1e6, "budget of each run in rollouts"),
      NumberOption("jacobian_cost_units", &optimiser.jacobian_cost_units, 0, 1000,
                   "cost of a Jacobian in rollouts, beside its own rollout"),
      NumberOption("num_seeds", &options.seeds, 1, 1000,
                   "runs of each stochastic method, with random seeds from 1"),
      NumberOption(
          "checkpoints", &options.checkpoints, 1, 1e6,
          "budgets at which tables also report the costs, where they are below the budget"),
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
          "convergence, profiles, data_profiles and branches; twins/ has the silhouettes that are "
          "fitted, cells/ the finished runs, from which the same command continues\n"
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
