// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "losses/dataset/dataset.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/posterior/space/space_io.h"
#include "solver/studies/recognition/recognition.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/fit_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

// The options of drape_space.
struct SpaceToolOptions {
  SpaceToolOptions() {
    fit.spec.model = FitModel::kBayes;
    fit.spec.simpler_models = false;  // their tables would be bases of their own
    fit.spec.backend = "cpu";         // fits of one image each run side by side on its threads
    learning.pool.mesh = "disc:600";
  }

  std::vector<std::string> posteriors;  // folders of fits
  std::vector<std::string> added;       // folders of fits, or material files
  SpaceBy by = SpaceBy::kDrape;

  // Fits of a data set instead of posteriors.
  std::string data, fabrics, samples, captures;  // ParseIndexList; empty: all
  FitToolOptions fit;
  bool recognise = false;  // RecognitionJob
  std::vector<std::string> ways = {"posterior", "predictions", "features"};
  LearningOptions learning;  // its further rounds are not used
  StudyOptions study;        // of the fits
};

OptionTable SpaceTable(SpaceToolOptions& options);

// Options that change no fit, or whose choice the files of a fit hold.
const std::set<std::string> kFreeOfFits = {"by",       "data_fabric", "samples",
                                           "captures", "threads",     "recognise",
                                           "ways",     "pool_drapes", "pool_mesh"};

std::vector<Option> SpaceOptions(SpaceToolOptions& options) {
  return {PathOption("posteriors", &options.posteriors,
                     "folders of drape_fit --model=bayes or bdp, one of each fabric"),
          PathOption("new", &options.added,
                     "materials to judge by these fabrics: folders of fits, or material files"),
          EnumOption("by", options.by,
                     "drape: stiffness over density, which is all that a drape shows; weight: "
                     "stiffness, with the density of each fit as weighed")};
}

std::vector<Option> DataOptions(SpaceToolOptions& options) {
  return {
      PathOption(
          "data", &options.data,
          "folder of the published data set, whose fabrics are fitted instead of posteriors"),
      PlainOption("data_fabric", &options.fabrics, "with --data: fabrics, as in 1,3-5; empty: all"),
      PlainOption("samples", &options.samples,
                  "with --data: samples to fit, as in 1,3-5; empty: all"),
      PlainOption("captures", &options.captures,
                  "with --data: captures to fit, as in 1,3; empty: all"),
      FabricOption(&options.fit.data.material),
      ThreadsOption(options.fit.spec.threads)};
}

std::vector<Option> RecognitionOptions(SpaceToolOptions& options) {
  std::vector<Option> all = {
      PlainOption("recognise", &options.recognise,
                  "with --data: tell the fabric of each sample from the other samples"),
      ChoiceOption(
          "ways", &options.ways, {"posterior", "predictions", "features"},
          "evidence to use; several are also combined: posterior (of a fit of each sample "
          "alone), predictions (drapes of learned distributions of specimens, from a pool of "
          "simulated drapes, without a fit), features (of the images alone)"),
      MeshOption("pool_mesh", &options.learning.pool.mesh,
                 "cloth of the pool; it may differ from `mesh`, that of the fits")};
  for (Option& option : PoolOptionRows(options.learning))
    if (option.key == "pool" || option.key == "pool_drapes") all.push_back(std::move(option));
  return all;
}

void CheckSource(const SpaceToolOptions& options) {
  if (options.data.empty() == options.posteriors.empty())
    throw InputError("options 'posteriors' and 'data'",
                     std::string("found ") + (options.data.empty() ? "neither" : "both") +
                         ", expected one of them");
  const bool fits = !options.recognise || std::find(options.ways.begin(), options.ways.end(),
                                                    "posterior") != options.ways.end();
  if (!options.data.empty() && fits)
    ReadMaterial(options.fit.data.material, {NegativeEntries::kWarn});  // before hours of work
  if (!fits && (options.study.list || !options.study.share.empty()))
    throw InputError("option 'ways'",
                     "found no 'posterior', expected it: only fits can be listed and shared");
  const auto needs_data = [&](const char* option, const std::string& value) {
    throw InputError(std::string("option '") + option + "'",
                     "found " + value + " without 'data', expected a data set");
  };
  if (!options.data.empty()) return;
  if (options.recognise) needs_data("recognise", "true");
  if (options.study.list) needs_data("list", "true");
  if (!options.study.share.empty()) needs_data("share", "'" + options.study.share + "'");
}

std::vector<Capture> SelectedCaptures(const SpaceToolOptions& options, const RunControl& control) {
  std::vector<FileNote> skipped;
  const Selection selection{.fabrics = ParseIndexList(options.fabrics, "option 'fabrics'"),
                            .samples = ParseIndexList(options.samples, "option 'samples'"),
                            .captures = ParseIndexList(options.captures, "option 'captures'")};
  std::vector<Capture> usable = KeepUsable(Select(ReadDataset(options.data), selection), &skipped);
  for (const FileNote& note : skipped) control.Log("skipped: " + note.text);
  return usable;
}

ToolOutcome BuildSpace(const SpaceToolOptions& options, const std::vector<std::string>& folders,
                       const OutputFolder& out) {
  std::vector<std::string> summaries;
  for (const auto* list : {&folders, &options.added})
    for (const std::string& folder : *list) summaries.push_back(folder + "/summary.json");
  FindDiscs({}, summaries);  // fits of one size
  FabricBeliefs beliefs = ReadFabricBeliefs(folders, options.by);
  std::vector<FabricBelief> added;
  for (const std::string& path : options.added)
    added.push_back(ReadFabricBelief(beliefs.frame, path));
  const MaterialSpace space = BuildMaterialSpace(std::move(beliefs), std::move(added));
  WriteMaterialSpace(out.Staged(""), space, MakeProvenance());
  return {.text = MaterialSpaceText(space) + RunStudyScript("space", out.Staged(""))};
}

// Before hours of work: without a device, each fit would fail.
void CheckBackend(const SpaceToolOptions& options, const RunControl& control) {
  const FitSpec& fit = options.fit.spec;
  MakeLoggedBackend(fit.backend,
                    std::make_shared<const ClothModel>(ParseMeshSpec(fit.mesh),
                                                       CusickScene(fit.contact), MakeLaw(fit.law)),
                    1, control);
}

// The fits of each fabric of a data set, or of each sample.
FitCellJob MakeFitCellJob(const SpaceToolOptions& options) {
  FitCellJob job;
  job.fit = MakeFitSpec(options.fit);
  job.material = options.fit.data.material;
  job.provenance = MakePartProvenance;
  SpaceToolOptions copy = options;
  job.settings = OptionSettings(SpaceTable(copy), kFreeOfFits);
  job.study = options.study;
  job.study.out += options.recognise ? "/samples" : "/fabrics";
  job.study.threads = job.fit.threads;
  if (options.recognise)  // a sample is one specimen
    job.fit.posterior.specimen_stretch_sigma = job.fit.posterior.specimen_bend_sigma = 0.0;
  return job;
}

// The space of the fabrics of a data set; only their list or a share of their fits without `out`.
ToolOutcome FitSpace(const SpaceToolOptions& options, const std::vector<Capture>& captures,
                     const OutputFolder* out, const RunControl& control) {
  const FitCellJob job = MakeFitCellJob(options);
  const FitCellRun run = RunFitCells(job, MakeFitCells(captures, options.recognise), control);
  const bool ends = out == nullptr || run.study.cancelled;
  ToolOutcome outcome{.text = run.study.text, .cancelled = run.study.cancelled};
  if (!ends) {
    std::vector<std::string> folders;
    for (const std::string& name : run.done) folders.push_back(job.study.out + "/" + name);
    outcome = BuildSpace(options, folders, *out);
  }
  for (const FitFailure& failure : run.failures)
    outcome.text += "no result: " + failure.name + ": " + MakePrintableLine(failure.reason) + "\n";
  return outcome;
}

ToolOutcome RunRecognition(const SpaceToolOptions& options, const std::vector<Capture>& captures,
                           const OutputFolder& out, const RunControl& control) {
  RecognitionJob job{.ways = {options.ways.begin(), options.ways.end()},
                     .fits = MakeFitCellJob(options),
                     .cells = MakeFitCells(captures, true),
                     .images = ObserveCaptures(captures, Camera()),
                     .by = options.by,
                     .learning = options.learning};
  if (job.learning.pool_file.empty()) job.learning.pool_file = options.study.out + "/pool.json";
  job.learning.fit.threads = job.fits.study.threads;
  const auto recognition = Recognise(job, control);
  if (!recognition) return {.cancelled = true};
  WriteWithProvenance(out.Staged("recognition.json"), *recognition);
  return {.text = RunStudyScript("space", out.Staged(""))};
}

ToolOutcome RunSpace(const SpaceToolOptions& options, const RunControl& control) {
  CheckShare(options.study);
  CheckSource(options);
  if (options.study.list)
    return FitSpace(options, SelectedCaptures(options, control), nullptr, control);
  if (!options.posteriors.empty()) ReadFabricBeliefs(options.posteriors, options.by);
  const bool is_share = !options.study.share.empty();
  const OutputFolder out(options.study.out, {"space.json", "distances.csv", "recognition.json"},
                         is_share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  ToolOutcome outcome;
  if (!options.posteriors.empty()) {
    outcome = BuildSpace(options, options.posteriors, out);
  } else {
    CheckBackend(options, control);
    const std::vector<Capture> captures = SelectedCaptures(options, control);
    if (is_share) return FitSpace(options, captures, nullptr, control);
    outcome = options.recognise ? RunRecognition(options, captures, out, control)
                                : FitSpace(options, captures, &out, control);
  }
  if (!outcome.cancelled) out.Publish();
  return outcome;
}

OptionTable SpaceTable(SpaceToolOptions& options) {
  return {
      .tool = "drape_space",
      .summary =
          "the space of materials: how far fabrics are apart, whether a new material is one "
          "of them, and which fabric a sample is of",
      .example = "drape_space --posteriors=out/fabric_1,out/fabric_2,out/fabric_3 --out=out/space",
      .notes =
          "files: space.json, distances.csv (one line for each pair of fabrics and level), "
          "heat_map (Hellinger metric, white where a pair has no determined direction, and a tree "
          "by average linkage), map (Wasserstein metric in a plane) and textile_map (bending "
          "lengths along warp and weft), each as SVG and PNG; with --recognise recognition.md and "
          "recognition.json\n"
          "All fits must have the same free numbers and prior. drape_fit --prior=space.json takes "
          "the population of the fabrics as the prior of another one.\n"
          "--data: fits in out/fabrics/fabric_<N> or, with --recognise, "
          "out/samples/fabric_<N>/sample_<K>, one on each thread. After Ctrl-C or a kill the same "
          "command continues with the unfinished ones. A fit that fails is named and left out.\n"
          "--list, --share: the cells are the fits.\n"
          "--recognise --ways=predictions,features needs no fit: with an existing pool it takes a "
          "minute.\n",
      .options =
          Concatenate(Grouped("space", SpaceOptions(options)),
                      Grouped("fits of a data set (--data)",
                              Concatenate(DataOptions(options), StudyOptionList(options.study))),
                      Grouped("recognition (--recognise)", RecognitionOptions(options)),
                      FitOptionsOfCells(options.fit, {"prior", "threads"})),
      .common = {"posteriors", "new", "by", "data", "data_fabric", "samples", "captures", "fabric",
                 "recognise", "ways", "pool", "mesh", "num_parameters", "threads", "backend",
                 "share", "out"}};
}

}  // namespace

int SpaceMain(int argc, char** argv) { return ToolMain(argc, argv, SpaceTable, RunSpace); }

}  // namespace drape
