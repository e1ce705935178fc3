// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/fit/fit_tool.h"

#include <algorithm>
#include <cstdio>
#include <thread>

#include "physics/util/errors.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"

namespace drape {
namespace {

void TakeData(const FitToolOptions& options, FitJob* job) {
  const FitSelection& data = options.data;
  if (data.folder.empty()) {
    const FitSelection none;
    if (data.fabric != none.fabric || data.samples + data.captures != "" ||
        data.face != none.face || job->targets != ObservationSource::kSilhouettes)
      throw InputError("option 'data'",
                       "none, expected the data set that fabric, samples, captures, face and "
                       "targets choose from");
    return;
  }
  if (!options.images.empty())
    throw InputError("option 'images'", "found some beside --data, expected one of both");
  SelectCaptures(data, job);
}

}  // namespace

FitJob MakeFitJob(const FitToolOptions& options) {
  FitJob job = options.job;
  for (const std::string& image : options.images) {
    const auto files = ExpandImages(image);
    job.images.insert(job.images.end(), files.begin(), files.end());
  }
  for (const std::string& test : options.tests) {
    const auto files = ExpandTests(test);
    job.tests.insert(job.tests.end(), files.begin(), files.end());
  }
  if (job.fit.keep.size() != job.fit.iterations.size()) {
    throw InputError("option 'iterations'",
                     "found " + std::to_string(job.fit.iterations.size()) + " values, expected " +
                         std::to_string(job.fit.keep.size()) + ", as many rounds as 'keep' has");
  }
  if (job.posterior.draws % 2 != 0) {
    throw InputError("option 'posterior_samples'",
                     "found " + std::to_string(job.posterior.draws) + ", expected an even number");
  }
  job.fit.parameters = ParseParameterTying(options.parameters);
  job.tables = ParseTableForm(options.tables);
  job.fit.integrator = ParseSolveMode(options.integrator);
  job.targets = ParseObservationSource(options.targets);
  TakeData(options, &job);
  job.fields.basis = ParseFieldBasis(options.field_basis);
  job.fields.groups = ParseFieldGroups(options.field_groups);
  if (job.threads == 0) job.threads = std::max(1u, std::thread::hardware_concurrency());
  for (const auto& [name, version] : Versions()) job.versions[name] = version;
  return job;
}

FitJobResult RunFitTool(const FitToolOptions& given, const FitJobCallbacks& callbacks) {
  FitToolOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  if (!picked.empty() && callbacks.log) callbacks.log(picked);
  FitJob job = MakeFitJob(options);
  const OutputFolder out(options.out);
  job.out = out.Staged("");
  job.checkpoint = options.out + "/checkpoint.json";
  job.log = options.out + "/fit.log";
  FitJobResult result = RunFitJob(job, callbacks);
  if (!picked.empty()) result.table = picked + "\n" + result.table;
  out.Publish();
  return result;
}

std::string ProgressNote(const FitProgress& progress) {
  if (progress.profile_rms <= 0) return progress.stage;
  char best[48];
  std::snprintf(best, sizeof best, ", best %.2f px", progress.profile_rms);
  return progress.stage + best;
}

std::string ApplyAccuracy(FitToolOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  const bool at_rest = options->integrator == "static";
  const AccuracyRow row = PickAccuracy(choice, at_rest ? "hybrid" : "dynamic");
  AccuracyFilling filling(choice);
  filling.Set("mesh", row.mesh, &options->job.mesh);
  filling.Set("settle_time_step", row.h, &options->job.fit.settle_h);
  filling.Set("settle_steps", row.steps, &options->job.fit.settle_steps);
  return filling.Line(row);
}

}  // namespace drape
