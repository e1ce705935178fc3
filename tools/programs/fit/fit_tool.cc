// SPDX-License-Identifier: Apache-2.0
#include "physics/util/errors.h"
#include "physics/util/stored/stored_json.h"
#include "solver/job/fit_checkpoint.h"
#include "solver/job/fit_data.h"
#include "solver/job/fit_job.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/fit_options.h"
#include "tools/inputs/samples.h"
#include "tools/programs/fit/each_fit.h"

namespace drape {
namespace {

// "see out/fit_a.png, out/material.json"; of many pictures the first two.
std::string SeeLine(const std::string& folder, std::vector<std::string> names) {
  constexpr std::size_t kMost = 3;
  std::string line = "see ";
  if (names.size() > kMost) names.erase(names.begin() + kMost - 1, names.end() - 1);
  for (std::size_t i = 0; i < names.size(); ++i)
    line += (i == 0 ? "" : ", ") + folder + "/" + names[i];
  return line + "\n";
}

void CheckNoSelection(const FitToolOptions& options) {
  const FitSelection& given = options.selection;
  const FitSelection unset;
  if (given.fabric != unset.fabric || given.samples + given.captures != "" ||
      given.face != unset.face || options.data.source != FitData().source)
    throw InputError(
        "option 'data'",
        "not given, expected the data set that data_fabric, samples, captures, face and "
        "data_source choose from");
}

// Lists the files of the data and reads the list of the data set. A table of samples sets what the
// user has not given.
FitData MakeFitData(const FitToolOptions& options, FitSpec* spec) {
  FitData data = options.data;
  if (!data.experiment.empty())
    for (const char* key : kClothOptions)
      if (options.accuracy.given.contains(key))
        throw InputError(std::string("option '") + key + "'",
                         "found one beside 'experiment', expected none: its file says what is "
                         "simulated");
  for (const std::string& image : options.images) AddImages(image, spec, &data);
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

// Sets the options that the user has not given from --accuracy. Returns one line that says what was
// picked and which error to expect; empty without --accuracy.
std::string ApplyAccuracy(FitToolOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  ResidualOptions& residuals = options->spec.stages.residuals;
  const bool at_rest = residuals.solve_mode == SolveMode::kStatic;
  const AccuracyRow row = PickAccuracy(choice, at_rest ? "hybrid" : "dynamic");
  AccuracyFilling filling(choice);
  filling.Set("mesh", row.mesh, &options->spec.mesh);
  filling.Set("settle_time_step", row.h, &residuals.rollout.h);
  filling.Set("settle_steps", row.steps, &residuals.rollout.steps);
  return filling.Line(row);
}

// Runs the fit. The results appear in `out` together at the end; checkpoint.json and fit.log are
// there while it runs.
ToolOutcome Run(const FitToolOptions& given, const RunControl& control) {
  FitToolOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  if (!picked.empty()) control.Log(picked);
  FitSpec spec = MakeFitSpec(options);
  const FitData data = MakeFitData(options, &spec);
  if (options.each) return FitEach(options, spec, data, control);
  const OutputFolder out(options.out, {"summary.json", "material.json", "posterior.json",
                                       "base.json", "fit.log", "checkpoint.json", "outlines.json"});
  FitFiles files{.out = out.Staged(""),
                 .target = options.out,
                 .checkpoint = options.out + "/checkpoint.json",
                 .resume = options.resume,
                 .outlines = options.out + "/outlines.json",
                 .log = options.out + "/fit.log",
                 .provenance = MakeProvenance};
  if (!options.resume) CheckStored(files.checkpoint, kCheckpointFormat);
  FitJobResult result = RunFitJob(spec, data, files, control);
  if (!picked.empty()) result.table = picked + "\n" + result.table;
  if (result.fitted) result.table += SeeLine(options.out, result.results);
  out.Publish();
  return {.text = std::move(result.table),
          .cancelled = result.cancelled,
          .failure = result.fitted ? "" : "nothing could be fitted, see summary.json"};
}

}  // namespace

int FitMain(int argc, char** argv) { return ToolMain(argc, argv, FitTable, Run); }

}  // namespace drape
