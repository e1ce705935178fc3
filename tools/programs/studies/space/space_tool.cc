// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/space/space_tool.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "losses/dataset/index_list.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/posterior/space/space_io.h"
#include "solver/posterior/space/space_picture.h"
#include "solver/studies/recognition/recognition.h"
#include "tools/cli/field_options.h"
#include "tools/cli/option_text.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

// Options of drape_fit that each fit of the data set has set.
const std::set<std::string> kOfCells = {
    "images",     "lab_tests",   "material",       "density", "ground_truth",    "model",
    "out",        "resume",      "data",           "fabric",  "samples",         "captures",
    "face",       "data_source", "camera",         "solve",   "accuracy",        "specimens",
    "table_form", "prior",       "accuracy_table", "threads", "other_materials", "specimen",
    "support"};
// Options that change no fit.
const std::set<std::string> kFree = {
    "data",      "out",   "fabrics",   "posteriors", "new",         "by",   "threads",
    "recognise", "draws", "calibrate", "start_rms",  "capture_rms", "list", "share"};
// Options that change predictions.
const std::set<std::string> kOfPredictions = {"by", "draws", "calibrate", "start_rms",
                                              "capture_rms"};

std::vector<Option> SpaceOptions(SpaceToolOptions& options) {
  return {{.key = "posteriors",
           .value = &options.posteriors,
           .doc = "folders of drape_fit --model=bayes or bdp, one of each fabric",
           .is_path = true},
          {.key = "new",
           .value = &options.added,
           .doc = "materials to judge by these fabrics: folders of fits, or material files",
           .is_path = true},
          EnumOption("by", options.by,
                     "drape: stiffness over density, which is all that a drape shows; weight: "
                     "stiffness, with the density of each fit as weighed"),
          OutOption(options.out)};
}

std::vector<Option> DataOptions(SpaceToolOptions& options) {
  const auto list = [](const char* key, std::string* value, const char* doc) {
    return Option{.key = key, .value = value, .doc = doc};
  };
  return {
      {.key = "data",
       .value = &options.data,
       .doc = "folder of the published data set, whose fabrics are fitted instead of posteriors",
       .is_path = true},
      list("fabrics", &options.fabrics, "with --data: fabrics, as in 1,3-5; empty: all"),
      list("samples", &options.samples, "with --data: samples to fit, as in 1,3-5; empty: all"),
      list("captures", &options.captures, "with --data: captures to fit, as in 1,3; empty: all"),
      {.key = "material",
       .value = &options.fit.data.material,
       .doc = "with --data: start tables of all fits",
       .is_path = true},
      ThreadsOption(options.fit.spec.threads)};
}

std::vector<Option> RecognitionOptions(SpaceToolOptions& options) {
  const auto height = [](const char* key, double* value, const char* doc) {
    return Option{.key = key, .value = value, .doc = doc, .unit = "m", .least = 0, .most = 0.05};
  };
  return {
      {.key = "recognise",
       .value = &options.recognise,
       .doc = "with --data: fit each sample alone, and tell the fabric of each from the others"},
      {.key = "draws",
       .value = &options.draws,
       .doc = "number of drapes that are predicted of each fabric, with and without each of its "
              "samples; 0: recognition without predicted drapes",
       .least = 0,
       .most = 4096},
      {.key = "calibrate",
       .value = &options.calibrate,
       .doc = "calibrate bend for each prediction first, as drape_predict does"},
      height("start_rms", &options.prediction.start_rms,
             "root mean square height of a specimen's random start shape at the hem"),
      height("capture_rms", &options.prediction.capture_rms,
             "root mean square noise of each vertex at the start of each drape")};
}

std::map<std::string, std::string> Settings(
    const SpaceToolOptions& options, const std::function<bool(const std::string& key)>& has) {
  std::map<std::string, std::string> settings = {{"drapefit", BuildVersion()}};
  SpaceToolOptions copy = options;
  for (const Option& option : SpaceTable(copy).options)
    if (has(option.key)) settings[option.key] = ValueText(option);
  return settings;
}

void CheckSource(const SpaceToolOptions& options) {
  if (options.data.empty() == options.posteriors.empty())
    throw InputError("options 'posteriors' and 'data'",
                     std::string("found ") + (options.data.empty() ? "neither" : "both") +
                         ", expected one of them");
  if (!options.data.empty() && options.fit.data.material.empty())
    throw InputError("option 'material'", "not given, expected the start tables of the fits");
  if (!options.data.empty())
    ReadMaterial(options.fit.data.material, {NegativeEntries::kWarn});  // before hours of work
  const auto needs_data = [&](const char* option, const std::string& value) {
    throw InputError(std::string("option '") + option + "'",
                     "found " + value + " without 'data', expected a data set");
  };
  if (!options.data.empty()) return;
  if (options.recognise) needs_data("recognise", "true");
  if (options.cells.list) needs_data("list", "true");
  if (!options.cells.share.empty()) needs_data("share", "'" + options.cells.share + "'");
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

FitCellJob MakeFitCellJob(const SpaceToolOptions& options, const std::string& folder) {
  FitCellJob job{
      .fit = MakeFitSpec(options.fit),
      .material = options.fit.data.material,
      .out = options.out + "/" + folder,
      .settings = Settings(options, [](const std::string& key) { return !kFree.contains(key); })};
  job.threads = job.fit.threads;
  job.provenance = MakePartProvenance;
  return job;
}

std::string FailureText(const std::vector<FitFailure>& failures) {
  std::string text;
  for (const FitFailure& failure : failures)
    text += "no result: " + failure.name + ": " + MakePrintableLine(failure.reason) + "\n";
  return text;
}

std::string WriteSpace(const MaterialSpace& space, const std::vector<FabricBelief>& added,
                       const OutputFolder& out) {
  WriteMaterialSpace(out.Staged(""), space, MakeProvenance());
  return TryPictures([&] {
    RenderHeatMap(out.Staged("heat_map.png"), space);
    RenderSpaceMap(out.Staged("map.png"), space);
    RenderTextileMap(out.Staged("textile_map.png"), space, added);
  });
}

SpaceResult BuildSpace(const SpaceToolOptions& options, const std::vector<std::string>& folders,
                       const OutputFolder& out) {
  std::vector<std::string> summaries;
  for (const auto* list : {&folders, &options.added})
    for (const std::string& folder : *list) summaries.push_back(folder + "/summary.json");
  FindDiscs({}, summaries);  // fits of one size
  FabricBeliefs beliefs = ReadFabricBeliefs(folders, options.by);
  std::vector<FabricBelief> added;
  for (const std::string& path : options.added)
    added.push_back(ReadFabricBelief(beliefs.frame, path));
  const MaterialSpace space = BuildMaterialSpace(std::move(beliefs), added);
  return {.text = MaterialSpaceText(space) + WriteSpace(space, added, out)};
}

// Before hours of work: without a device, each fit would fail.
void CheckBackend(const SpaceToolOptions& options, const RunControl& control) {
  const FitSpec& fit = options.fit.spec;
  MakeLoggedBackend(fit.backend,
                    std::make_shared<const ClothModel>(ParseMeshSpec(fit.mesh),
                                                       CusickScene(fit.contact), MakeLaw(fit.law)),
                    1, control);
}

// A run of fits of a data set: of each fabric, or of each sample and then predictions.
constexpr char kFabrics[] = "fabrics", kSamples[] = "samples";

RecognitionJob MakeRecognitionJob(const SpaceToolOptions& options,
                                  const std::vector<Capture>& captures) {
  RecognitionJob job{.fits = MakeFitCellJob(options, kSamples)};
  // A sample is one specimen.
  job.fits.fit.posterior.specimen_stretch_sigma = job.fits.fit.posterior.specimen_bend_sigma = 0.0;
  job.cells = CellsBySample(captures);
  job.by = options.by;
  job.draws = options.draws;
  job.calibrate = options.calibrate;
  job.prediction = options.prediction;
  job.prediction_settings =
      Settings(options, [](const std::string& key) { return kOfPredictions.contains(key); });
  job.share = options.cells.ParseShare();
  return job;
}

SpaceResult ListCells(const SpaceToolOptions& options, const RunControl& control) {
  const std::vector<Capture> captures = SelectedCaptures(options, control);
  std::vector<std::string> names;
  if (options.recognise)
    names = ListRecognitionCells(MakeRecognitionJob(options, captures));
  else
    for (const FitCell& cell : CellsByFabric(captures)) names.push_back(cell.name);
  for (std::string& name : names)
    name = std::string(options.recognise ? kSamples : kFabrics) + "/" + name;
  return {.text = ListText(names, options.cells.ParseShare())};
}

SpaceResult RunFitShare(const SpaceToolOptions& options, const std::vector<Capture>& captures,
                        const RunControl& control) {
  const std::vector<FitCell> own =
      CellsOfShare(CellsByFabric(captures), *options.cells.ParseShare());
  const FitCellRun run = RunFitCells(MakeFitCellJob(options, kFabrics), own, control);
  return {.cancelled = run.cancelled,
          .text = FailureText(run.failures) +
                  ShareText(options.cells.share, own.size() - run.missing.size(), own.size())};
}

SpaceResult RunShareOfRecognition(const SpaceToolOptions& options,
                                  const std::vector<Capture>& captures, const RunControl& control) {
  RecognitionJob job = MakeRecognitionJob(options, captures);
  job.images = ObserveCaptures(captures, Camera());
  const RecognitionShare share = RunRecognitionShare(job, control);
  SpaceResult result{.cancelled = share.cancelled,
                     .text = FailureText(share.failures) +
                             ShareText(options.cells.share, share.done, share.cells)};
  if (share.waiting > 0)
    result.text += std::to_string(share.waiting) +
                   " predictions need fits of other shares: run this share again when the fits of "
                   "all shares have ended\n";
  return result;
}

SpaceResult FitSpace(const SpaceToolOptions& options, const std::vector<Capture>& captures,
                     const OutputFolder& out, const RunControl& control) {
  const FitCellJob job = MakeFitCellJob(options, kFabrics);
  const FitCellRun run = RunFitCells(job, CellsByFabric(captures), control);
  if (run.cancelled) return {.cancelled = true, .text = ""};
  std::vector<std::string> folders;
  for (const std::string& name : run.done) folders.push_back(job.out + "/" + name);
  SpaceResult result = BuildSpace(options, folders, out);
  result.text += FailureText(run.failures);
  return result;
}

SpaceResult RunRecognition(const SpaceToolOptions& options, const std::vector<Capture>& captures,
                           const OutputFolder& out, const RunControl& control) {
  RecognitionJob job = MakeRecognitionJob(options, captures);
  job.images = ObserveCaptures(captures, Camera());
  const Recognition recognition = Recognise(job, control);
  if (recognition.cancelled) return {.cancelled = true, .text = ""};
  const std::string report = RecognitionReport(recognition);
  WriteFileAtomically(out.Staged("recognition.md"), report);
  return {.text = report};
}

SpaceResult RunOnData(const SpaceToolOptions& options, const OutputFolder& out,
                      const RunControl& control) {
  CheckBackend(options, control);
  const std::vector<Capture> captures = SelectedCaptures(options, control);
  if (options.cells.ParseShare())
    return options.recognise ? RunShareOfRecognition(options, captures, control)
                             : RunFitShare(options, captures, control);
  return options.recognise ? RunRecognition(options, captures, out, control)
                           : FitSpace(options, captures, out, control);
}

}  // namespace

OptionTable SpaceTable(SpaceToolOptions& options) {
  std::vector<Option> all =
      Concatenate(Grouped("space", SpaceOptions(options)),
                  Grouped("fits of a data set (--data)",
                          Concatenate(DataOptions(options), CellOptions(options.cells))),
                  Grouped("recognition (--recognise)", RecognitionOptions(options)));
  for (const Option& option : FitTable(options.fit).options)
    if (!kOfCells.contains(option.key)) all.push_back(option);
  return {
      .tool = "drape_space",
      .summary =
          "the space of materials: how far fabrics are apart, whether a new material is one "
          "of them, and which fabric a sample is of",
      .example = "drape_space --posteriors=out/fabric_1,out/fabric_2,out/fabric_3 --out=out/space",
      .notes =
          "files: space.json, distances.csv (one line per pair of fabrics and level), heat_map.png "
          "(Hellinger metric, white where a pair has no determined direction, and a tree by "
          "average "
          "linkage), map.png (Wasserstein metric in a "
          "plane), textile_map.png (bending lengths along warp and weft); with --recognise "
          "recognition.md\n"
          "All fits must have the same free numbers and prior. drape_fit --prior=space.json takes "
          "the population of the fabrics as the prior of another one.\n"
          "--data: fits in out/fabrics/fabric_<N> or, with --recognise, "
          "out/samples/fabric_<N>/sample_<K>, one on each thread, which share a GPU. After Ctrl-C "
          "or a kill the same "
          "command continues with the unfinished ones. A fit that fails is named and left out; "
          "failure.json in its folder says why, and is to be removed to try it again.\n"
          "--list, --share: the cells are the fits and, with --recognise, after them the "
          "predictions, each of which needs the fits of all samples. A share fits first and "
          "predicts if all fits have ended; otherwise it says how many predictions wait: run the "
          "shares twice, the second time when all have ended the first, or let the command without "
          "--share predict.\n",
      .options = std::move(all),
      .common = {"posteriors", "new", "by", "data", "fabrics", "samples", "captures", "material",
                 "recognise", "draws", "mesh", "num_parameters", "threads", "backend", "share",
                 "out"}};
}

SpaceResult RunSpaceTool(const SpaceToolOptions& options, const RunControl& control) {
  CheckSource(options);
  const std::optional<Share> share = options.cells.ParseShare();
  if (options.cells.list) return ListCells(options, control);
  if (!options.posteriors.empty()) ReadFabricBeliefs(options.posteriors, options.by);
  const OutputFolder out(options.out,
                         {"space.json", "distances.csv", "heat_map.png", "map.png",
                          "textile_map.png", "recognition.md"},
                         share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  SpaceResult result = options.posteriors.empty() ? RunOnData(options, out, control)
                                                  : BuildSpace(options, options.posteriors, out);
  if (!result.cancelled && !share) out.Publish();
  return result;
}

}  // namespace drape
