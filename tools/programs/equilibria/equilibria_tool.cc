// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/cloth/state.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/text_format.h"
#include "solver/forward/random_drapes.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/results/tables/outline_list.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// The options of drape_equilibria.
struct EquilibriaOptions {
  SceneInput scene;                        // its start is not used
  SamplingOptions sampling{.threads = 0};  // 0: all cores
  BranchMetric distance = BranchMetric::kVertices;
  double tolerance = 1e-3;       // of a cluster [m]
  std::string backend = "auto";  // MakeBackend
  std::string out;               // folder, made when missing
};

// The results of drape_equilibria, for its report.
struct EquilibriumSurvey {
  bool cancelled = false;
  std::string backend;  // Backend::name
  std::vector<DrapeSample> samples;
  std::vector<BranchCluster> clusters;
  BranchSpread spread;
  double seconds = 0.0;
};

constexpr std::size_t kShownBranches = 10;

std::string Seeds(const EquilibriumSurvey& survey, const BranchCluster& cluster) {
  constexpr size_t kShown = 6;
  std::string text;
  for (size_t i = 0; i < cluster.members.size() && i < kShown; ++i)
    text += Format("%d ", survey.samples[cluster.members[i]].seed);
  return cluster.members.size() > kShown ? text + "…" : text;
}

std::string SpreadLine(const char* name, const Spread& spread, double unit, const char* unit_name) {
  return Format("  %-30s %10.4g %10.4g  %s\n", name, spread.mean / unit, spread.sd / unit,
                unit_name);
}

std::string SpreadText(const BranchSpread& spread) {
  return Format("spread of %-22d %10s %10s\n", spread.drapes, "mean", "sd") +
         SpreadLine("drape coefficient", spread.drape_coefficient, 1, "") +
         SpreadLine("folds", spread.folds, 1, "") +
         SpreadLine("outline of two, rms", spread.outline_rms, 1e-3, "mm") +
         SpreadLine("silhouettes of two, MSE", spread.silhouette_mse, 1, "");
}

std::string RestlessText(const EquilibriumSurvey& survey) {
  std::string text;
  for (const DrapeSample& sample : survey.samples) {
    if (sample.at_rest) continue;
    text += Format("seed %d did not come to rest: %s, force residual %.2g of the weight\n",
                   sample.seed, sample.status.c_str(), sample.residual);
  }
  return text;
}

// The number of branches, and what it says about the fabric.
std::string BranchCountText(const EquilibriumSurvey& survey) {
  const std::size_t branches = survey.clusters.size();
  const int drapes = survey.spread.drapes;
  std::string text =
      Format("%d drapes at rest, %zu branch%s", drapes, branches, branches == 1 ? "" : "es");
  if (drapes > 1 && 2 * branches > std::size_t(drapes))
    text +=
        ": hardly any two starts end in the same drape, so that the fabric is described by the "
        "spread of its drapes";
  return text + "\n";
}

Json ModesJson(const BranchSignature& signature) {
  Json modes = Json::array();
  for (const auto& mode : signature.modes) {
    modes.push_back({{"k", mode.k}, {"amplitude_m", mode.amplitude_m}, {"phase", mode.phase}});
  }
  return modes;
}

Json ClusterJson(const EquilibriumSurvey& survey, size_t index) {
  const BranchCluster& cluster = survey.clusters[index];
  const DrapeSample& best = survey.samples[cluster.members[0]];
  Json seeds = Json::array();
  for (const int member : cluster.members) seeds.push_back(survey.samples[member].seed);
  return {{"seeds", seeds},
          {"frequency", cluster.frequency},
          {"energy_J", best.energy},
          {"folds", best.signature.folds},
          {"dc", best.signature.drape_coefficient},
          {"modes", ModesJson(best.signature)},
          {"force_residual", cluster.residual},
          {"stable", cluster.stable},
          {"state", "branch_" + std::to_string(index + 1) + ".json"}};
}

Json SampleJson(const DrapeSample& sample) {
  Json json = {{"seed", sample.seed},
               {"status", sample.status},
               {"force_residual", sample.residual},
               {"newton_iterations", sample.newton_iterations}};
  if (!sample.at_rest) return json;
  json["energy_J"] = sample.energy;
  json["folds"] = sample.signature.folds;
  json["dc"] = sample.signature.drape_coefficient;
  return json;
}

Json SpreadJson(const Spread& spread) { return {{"mean", spread.mean}, {"sd", spread.sd}}; }

// One row for each of the largest clusters, then the spread over the drapes and the starts that did
// not come to rest.
std::string EquilibriaTableText(const EquilibriumSurvey& survey) {
  std::string text = Format("%7s %7s %6s %13s %6s %7s %9s %7s  %s\n", "branch", "drapes", "share",
                            "energy [mJ]", "folds", "DC", "residual", "stable", "seeds");
  for (size_t i = 0; i < survey.clusters.size() && i < kShownBranches; ++i) {
    const BranchCluster& cluster = survey.clusters[i];
    const DrapeSample& best = survey.samples[cluster.members[0]];
    text += Format("%7zu %7zu %6.3f %13.5f %6d %7.4f %9.1e %7s  %s\n", i + 1,
                   cluster.members.size(), cluster.frequency, 1e3 * best.energy,
                   best.signature.folds, best.signature.drape_coefficient, cluster.residual,
                   cluster.stable ? "yes" : "no", Seeds(survey, cluster).c_str());
  }
  if (survey.clusters.size() > kShownBranches)
    text += Format("%7s %zu more in summary.json\n", "…", survey.clusters.size() - kShownBranches);
  return text + BranchCountText(survey) + SpreadText(survey.spread) + RestlessText(survey);
}

// Throws InputError when the file cannot be written.
void WriteEquilibriaSummary(const std::string& path, const EquilibriaOptions& options,
                            const LoadedScene& scene, const EquilibriumSurvey& survey) {
  Json json = {{"outcome", survey.cancelled ? "cancelled" : "done"},
               {"at_rest", survey.spread.drapes},
               {"backend", survey.backend},
               {"material", scene.fabric.material.name},
               {"mesh", options.scene.mesh},
               {"vertices", scene.model->mesh.num_vertices()}};
  json.update(DiscsJson(scene.discs));
  json["spread"] = {{"dc", SpreadJson(survey.spread.drape_coefficient)},
                    {"folds", SpreadJson(survey.spread.folds)},
                    {"outline_rms_m", SpreadJson(survey.spread.outline_rms)},
                    {"silhouette_mse", SpreadJson(survey.spread.silhouette_mse)}};
  json["branches"] = Json::array();
  for (size_t i = 0; i < survey.clusters.size(); ++i)
    json["branches"].push_back(ClusterJson(survey, i));
  json["samples"] = Json::array();
  for (const DrapeSample& sample : survey.samples) json["samples"].push_back(SampleJson(sample));
  json["seconds"] = survey.seconds;
  WriteWithProvenance(path, std::move(json));
}

// Writes the outlines of the drapes at rest in the order of the table, with clusters as groups.
// Throws InputError when the file cannot be written.
void WriteEquilibriumOutlines(const std::string& path, const EquilibriumSurvey& survey) {
  std::vector<ListedOutline> outlines;
  for (size_t c = 0; c < survey.clusters.size(); ++c)
    for (const int member : survey.clusters[c].members) {
      const DrapeSample& sample = survey.samples[member];
      outlines.push_back({Format("branch %zu, seed %d", c + 1, sample.seed), static_cast<int>(c),
                          sample.signature.drape_coefficient, sample.signature.folds,
                          sample.outline});
    }
  WriteOutlines(path, outlines);
}

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
      NumberOption("samples", &sampling.samples, 1, 1000, "number of random starts"),
      NumberOption(
          "seed", &sampling.first_seed, 0, 1000000000,
          "random seed of the run: that of the first start shape; the others use the following "
          "ones"),
      PositiveOption("hem_rms", &sampling.hem_rms, 0.05,
                     "root mean square height of the start shapes at the hem", "m"),
      TimeStepOption(&sampling.h),
      NumberOption("steps", &sampling.steps, 0, 100000,
                   "number of time steps before Newton's method"),
      ThreadsOption(sampling.threads),
  };
}

std::vector<Option> ResultOptions(EquilibriaOptions& options) {
  return {
      EnumOption(
          "distance", options.distance,
          "distance of two drapes: between their vertices, or between their outlines as they "
          "lie (outline), after the best rotation (rotated), or after the best rotation and "
          "reflection (mirrored)"),
      PositiveOption("tolerance", &options.tolerance, 1,
                     "largest distance of two drapes on the same branch", "m"),
      OutOption(options.out),
  };
}

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
          Grouped("branches and results", ResultOptions(options)))};
}

// Reads all input before it computes. A cancelled run writes what it has.
ToolOutcome Run(const EquilibriaOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
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
  survey.clusters = ClusterSamples(survey.samples, options.distance, options.tolerance);
  survey.spread = ComputeSpread(survey.samples);
  survey.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  WriteEquilibriumStates(survey, scene.model->mesh, out);
  WriteEquilibriumOutlines(out.Staged(kOutlinesFile), survey);
  WriteEquilibriaSummary(out.Staged("summary.json"), options, scene, survey);
  out.Publish();
  return {.text = EquilibriaTableText(survey),
          .cancelled = survey.cancelled,
          .failure = survey.spread.drapes > 0 ? "" : "no start came to rest, see summary.json"};
}

}  // namespace

int EquilibriaMain(int argc, char** argv) { return ToolMain(argc, argv, EquilibriaTable, Run); }

}  // namespace drape
