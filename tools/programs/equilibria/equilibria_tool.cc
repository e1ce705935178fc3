// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/equilibria/equilibria_tool.h"

#include <chrono>

#include "physics/cloth/state.h"
#include "physics/mesh/obj_io.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/equilibria/equilibria_report.h"
#include "tools/programs/results/tables/outline_list.h"

namespace drape {
namespace {

void WriteEquilibriumStates(const EquilibriumSurvey& survey, const Mesh& mesh,
                            const OutputFolder& out) {
  for (size_t i = 0; i < survey.clusters.size(); ++i) {
    const Eigen::VectorXd& x = survey.samples[survey.clusters[i].members[0]].x;
    const std::string name = "branch_" + std::to_string(i + 1);
    WriteState(out.Staged(name + ".json"), {x, Eigen::VectorXd::Zero(x.size())});
    WriteObj(out.Staged(name + ".obj"), mesh, x);
  }
}

std::vector<Option> SampleOptions(SamplingOptions& sampling) {
  return {
      {.key = "samples",
       .value = &sampling.samples,
       .doc = "number of random starts",
       .least = 1,
       .most = 1000},
      {.key = "seed",
       .value = &sampling.first_seed,
       .doc = "random seed of the run: that of the first start shape; the others use the following "
              "ones",
       .least = 0,
       .most = 1000000000},
      {.key = "hem_rms",
       .value = &sampling.hem_rms,
       .doc = "root mean square height of the start shapes at the hem",
       .unit = "m",
       .least = 0,
       .most = 0.05,
       .above_least = true},
      TimeStepOption(sampling.h),
      {.key = "steps",
       .value = &sampling.steps,
       .doc = "number of time steps before Newton's method",
       .least = 0,
       .most = 100000},
      ThreadsOption(sampling.threads),
  };
}

std::vector<Option> ReportOptions(EquilibriaOptions& options) {
  return {
      {.key = "distance",
       .value = &options.distance,
       .doc = "distance of two drapes: between their vertices, or between their outlines as they "
              "lie (outline), after the best rotation (rotated), or after the best rotation and "
              "reflection (mirrored)",
       .choices = {"vertices", "outline", "rotated", "mirrored"}},
      {.key = "tolerance",
       .value = &options.tolerance,
       .doc = "largest distance of two drapes on the same branch",
       .unit = "m",
       .least = 0,
       .most = 1,
       .above_least = true},
      OutOption(options.out),
  };
}

}  // namespace

OptionTable EquilibriaTable(EquilibriaOptions& options) {
  return {
      .tool = "drape_equilibria",
      .summary =
          "finds the stable drapes of a fabric: random starts, taken to rest and grouped by shape",
      .example =
          "drape_equilibria --config=configs/programs/equilibria.json --samples=32 "
          "--out=out/branches",
      .notes =
          "files: summary.json, outlines.json (of all drapes, branch by branch, for drape_report) "
          "and, for each branch, branch_<i>.obj and branch_<i>.json, its drape of least energy, "
          "which drape_simulate can start from. They replace the files of an earlier run together, "
          "at the end.\n"
          "exit code 3: no start came to rest\n"
          "Ctrl-C writes the results so far.\n",
      .options = Concatenate(
          Grouped("cloth", ClothOptions(options.scene)),
          Grouped("simulation", Concatenate(SampleOptions(options.sampling),
                                            std::vector{BackendOption(options.backend)})),
          Grouped("branches and results", ReportOptions(options)))};
}

EquilibriumSurvey SurveyEquilibria(const EquilibriaOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  const BranchMetric metric = ParseName<BranchMetric>(options.distance, "distance");
  const LoadedScene scene = LoadScene(options.scene);
  SamplingOptions sampling = options.sampling;
  sampling.threads = CountThreads(sampling.threads);
  RequireDiscs(*scene.model, scene.discs, options.scene.mesh);
  sampling.discs = scene.discs;
  const auto backend = MakeLoggedBackend(options.backend, scene.model, sampling.threads, control);
  const OutputFolder out(options.out, {"summary.json", kOutlinesFile});
  EquilibriumSurvey survey;
  survey.backend = backend->name();
  survey.samples = SampleEquilibria(*backend, scene.fabric.material.field, sampling, control);
  survey.cancelled = static_cast<int>(survey.samples.size()) < sampling.samples;
  survey.clusters = ClusterSamples(survey.samples, metric, options.tolerance);
  survey.spread = ComputeSpread(survey.samples);
  survey.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  WriteEquilibriumStates(survey, scene.model->mesh, out);
  WriteEquilibriumOutlines(out.Staged(kOutlinesFile), survey);
  WriteEquilibriaSummary(out.Staged("summary.json"), options, scene, survey);
  out.Publish();
  return survey;
}

namespace {

ToolOutcome Run(const EquilibriaOptions& options, const RunControl& control) {
  const EquilibriumSurvey survey = SurveyEquilibria(options, control);
  return {.text = EquilibriaTableText(survey),
          .cancelled = survey.cancelled,
          .failure = survey.spread.drapes > 0 ? "" : "no start came to rest, see summary.json"};
}

}  // namespace

int EquilibriaMain(int argc, char** argv) { return ToolMain(argc, argv, EquilibriaTable, Run); }

}  // namespace drape
