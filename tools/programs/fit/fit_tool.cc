// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/fit/fit_tool.h"

#include <algorithm>
#include <thread>

#include "physics/util/errors.h"
#include "solver/job/fit_input.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"

namespace drape {
namespace {

void CheckNoSelection(const FitToolOptions& options) {
  const FitSelection& given = options.selection;
  const FitSelection unset;
  if (given.fabric != unset.fabric || given.samples + given.captures != "" ||
      given.face != unset.face || options.data.source != FitData().source)
    throw InputError("option 'data'",
                     "not given, expected the data set that fabric, samples, captures, face and "
                     "data_source choose from");
}

}  // namespace

FitSpec MakeFitSpec(const FitToolOptions& options) {
  FitSpec spec = options.spec;
  const StagedFitOptions& stages = spec.stages;
  if (stages.candidates_per_round.size() != stages.iterations.size()) {
    throw InputError("option 'iterations'", "found " + std::to_string(stages.iterations.size()) +
                                                " values, expected " +
                                                std::to_string(stages.candidates_per_round.size()) +
                                                ", as many rounds as 'candidates_per_round' has");
  }
  if (spec.posterior.draws % 2 != 0) {
    throw InputError("option 'posterior_samples'",
                     "found " + std::to_string(spec.posterior.draws) + ", expected an even number");
  }
  if (spec.threads == 0) spec.threads = std::max(1u, std::thread::hardware_concurrency());
  return spec;
}

FitData MakeFitData(const FitToolOptions& options) {
  FitData data = options.data;
  for (const std::string& image : options.images)
    for (std::string& file : ExpandImages(image)) data.images.push_back(std::move(file));
  for (const std::string& test : options.lab_tests)
    for (std::string& file : ExpandLabMeasurements(test))
      data.lab_measurements.push_back(std::move(file));
  if (options.selection.folder.empty()) {
    CheckNoSelection(options);
    return data;
  }
  if (!options.images.empty())
    throw InputError("option 'images'", "found some beside --data, expected one of both");
  SelectCaptures(options.selection, &data);
  return data;
}

FitJobResult RunFitTool(const FitToolOptions& given, const RunControl& control) {
  FitToolOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  if (!picked.empty()) control.Log(picked);
  const FitSpec spec = MakeFitSpec(options);
  const FitData data = MakeFitData(options);
  const OutputFolder out(options.out);
  FitFiles files{.out = out.Staged(""),
                 .checkpoint = options.out + "/checkpoint.json",
                 .resume = options.resume,
                 .log = options.out + "/fit.log"};
  for (const auto& [name, version] : Versions()) files.versions[name] = version;
  FitJobResult result = RunFitJob(spec, data, files, control);
  if (!picked.empty()) result.table = picked + "\n" + result.table;
  out.Publish();
  return result;
}

std::string ApplyAccuracy(FitToolOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  OutlineResidualOptions& residuals = options->spec.stages.residuals;
  const bool at_rest = residuals.solve_mode == SolveMode::kStatic;
  const AccuracyRow row = PickAccuracy(choice, at_rest ? "hybrid" : "dynamic");
  AccuracyFilling filling(choice);
  filling.Set("mesh", row.mesh, &options->spec.mesh);
  filling.Set("settle_time_step", row.h, &residuals.rollout.h);
  filling.Set("settle_steps", row.steps, &residuals.rollout.steps);
  return filling.Line(row);
}

}  // namespace drape
