// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "solver/studies/bench/speed_study.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

using nlohmann::json;

// The options of drape_speed.
struct SpeedOptions {
  SpeedJob job;           // meshes: none: built-in discs of the published numbers of vertices
  std::string published;  // ReadPublishedSpeeds; empty: none
  StudyOptions study = {.processes = true};
};

std::vector<Option> ClothAndSteps(SpeedOptions& options) {
  SpeedJob& job = options.job;
  return {
      MeshOption("mesh", &job.meshes,
                 "cloths: OBJ files, such as the published discs, or disc:N; none: built-in discs "
                 "of the published numbers of vertices"),
      FabricOption(&job.material),
      ChoiceOption("law", &job.law, {"reference", "smooth"},
                   "constitutive law: how stiffness depends on strain and curvature"),
      TimeStepOption(&job.h),
      NumberOption("steps", &job.steps, 1, 1000000, "number of time steps of a rollout"),
  };
}

std::vector<Option> MeasurementOptions(SpeedOptions& options) {
  SpeedJob& job = options.job;
  Option threads = ThreadsOption(job.threads);
  threads.doc = "number of threads; 0: one for each core. One rollout runs on one";
  return {
      BackendOption(job.backend),
      threads,
      NumberOption("batch", &job.batches, 1, 65536,
                   "numbers of equal rollouts computed together; times are for one of them"),
      NumberOption("repeats", &job.repeats, 1, 1000, "number of repeats of each rollout"),
      NumberOption("run_seconds", &job.seconds, 0, kUnlimited,
                   "time after which a rollout is not repeated again", "s"),
      PathOption("published", &options.published,
                 "table of figures of others, with their sources, to print beside"),
  };
}

OptionTable SpeedTable(SpeedOptions& options);

// The job with what follows from the options.
SpeedJob MakeJob(SpeedOptions options, const json& published) {
  SpeedJob job = options.job;
  job.settings = OptionSettings(SpeedTable(options), {"mesh", "batch", "published"});
  job.threads = CountThreads(job.threads);
  if (!job.meshes.empty()) return job;
  for (const json& vertices : published.value("vertices", json::array()))
    job.meshes.push_back("disc:" + vertices.dump());
  if (job.meshes.empty())
    throw InputError("option 'mesh'", "is empty, expected meshes, or published figures of some");
  return job;
}

OptionTable SpeedTable(SpeedOptions& options) {
  return {.tool = "drape_speed",
          .summary =
              "times a step of a drape, forward and backward, beside published figures of others",
          .example = "drape_speed --config=configs/studies/speed.json --out=out/speed",
          .notes =
              "files: speed.md (the table that is printed), speed.json; cells/ has the finished "
              "measurements, from which the same command continues\n"
              "Rollouts start from the flat cloth at rest. Each measurement is a process of "
              "its own, so that its peak memory is its own.\n",
          .options = Concatenate(Grouped("cloth and steps", ClothAndSteps(options)),
                                 Grouped("measurement and results", MeasurementOptions(options)),
                                 StudyOptionList(options.study))};
}

ToolOutcome Run(const SpeedOptions& options, const RunControl& control) {
  const json published = options.published.empty() ? json{{"rows", json::array()}}
                                                   : ReadPublishedSpeeds(options.published);
  const Study study = MakeSpeedStudy(MakeJob(options, published));
  const auto summarise = [&](const StudyResult& result) {
    nlohmann::ordered_json summary = SummariseCells(study, result);
    summary["has_built_in_meshes"] = options.job.meshes.empty();
    summary["published"] = published;
    return summary;
  };
  return RunStudyProgram(study, options.study, control, summarise);
}

}  // namespace

int SpeedMain(int argc, char** argv) { return ToolMain(argc, argv, SpeedTable, Run); }

}  // namespace drape
