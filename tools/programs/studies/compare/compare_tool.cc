// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/compare/compare_tool.h"

#include <set>
#include <utility>

#include "losses/dataset/index_list.h"
#include "physics/util/errors.h"
#include "tools/cli/option_text.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"
#include "tools/inputs/tool_options.h"

namespace drape {
namespace {

// Options of drape_fit that each cell sets for itself.
const std::set<std::string> kOfCells = {
    "images",    "lab_tests", "material", "density",  "ground_truth",   "model",     "out",
    "resume",    "data",      "fabric",   "samples",  "captures",       "face",      "data_source",
    "specimens", "camera",    "solve",    "accuracy", "accuracy_table", "table_form"};
// Options that change no number of a cell.
const std::set<std::string> kFree = {"data",   "out",   "fabrics", "materials",
                                     "models", "seeds", "threads"};

std::vector<Option> SplitOptions(CompareToolOptions& options) {
  ComparisonJob& job = options.job;
  return {
      {.key = "data",
       .value = &job.data,
       .doc = "folder of the published data set",
       .is_path = true,
       .required = true},
      {.key = "fabrics", .value = &options.fabrics, .doc = "of the data set, like 1,3-5"},
      {.key = "models",
       .value = &job.models,
       .doc = "some of homo, heter, bdp, bayes, as drape_fit --model has them; of isotropic and "
              "linear "
              "tables; of scales and columns, 2 and 7 numbers; of bend and bend_rows, 1 and 3 "
              "numbers with stretch "
              "as the seed grid has it; of elements, heter's other basis"},
      {.key = "seeds",
       .value = &job.seeds,
       .doc = "each draws a split, the same for all models, and the draws of posterior and drapes",
       .least = 0},
      {.key = "materials",
       .value = &job.materials,
       .doc = "start tables: one file for all fabrics, or one for each in their order",
       .is_path = true,
       .required = true},
      {.key = "train",
       .value = &job.train,
       .doc = "samples of each fabric to learn from; the others are held out",
       .least = 1,
       .most = 9999},
      {.key = "train_captures",
       .value = &options.train_captures,
       .doc = "captures of these samples that are fitted, like 1,3; none: all"},
      {.key = "face",
       .value = &options.face,
       .doc = "which face lies up: captures 1 and 2 are up, 3 and 4 down",
       .choices = {"up", "down", "both"}},
  };
}

std::vector<Option> DrawOptions(CompareToolOptions& options) {
  PredictionOptions& prediction = options.job.prediction;
  return {
      {.key = "draws",
       .value = &options.job.draws,
       .doc = "drapes drawn of each cell's fit, as many on each face that is held out",
       .least = 4,
       .most = 4096},
      {.key = "calibrate",
       .value = &options.job.calibrate,
       .doc =
           "a factor on the bend of a fit, for each face, by which falling drapes look like those "
           "it learnt from"},
      {.key = "start_rms",
       .value = &prediction.start_rms,
       .doc = "size of a specimen's random start shape at the hem, root mean square",
       .unit = "m",
       .least = 0,
       .most = 0.05},
      {.key = "capture_rms",
       .value = &prediction.capture_rms,
       .doc = "noise of each vertex on the start of each drape, root mean square",
       .unit = "m",
       .least = 0,
       .most = 0.05},
      {.key = "out",
       .value = &options.out,
       .doc = "output folder, made when missing; cells that are there are taken over",
       .is_path = true,
       .required = true},
  };
}

ComparisonJob MakeJob(const CompareToolOptions& options) {
  ComparisonJob job = options.job;
  job.fit = MakeFitJob(options.fit);
  job.fabrics = ParseIndexList(options.fabrics, "option 'fabrics'");
  if (job.fabrics.empty()) throw InputError("option 'fabrics'", "none, expected some");
  if (job.models.empty()) throw InputError("option 'models'", "none, expected some");
  if (job.seeds.empty()) throw InputError("option 'seeds'", "none, expected some");
  job.train_captures = ParseIndexList(options.train_captures, "option 'train_captures'");
  if (options.face != "both") job.face = options.face == "up" ? ClothFace::kUp : ClothFace::kDown;
  job.out = options.out;
  CompareToolOptions copy = options;
  for (const Option& option : CompareTable(copy).options)
    if (!kFree.contains(option.key)) job.settings[option.key] = ValueText(option);
  job.settings["drapefit"] = DrapefitVersion();
  return job;
}

// A comparison without charts is one all the same.
void RenderCharts(const OutputFolder& out, const Comparison& comparison,
                  const RunControl& control) {
  try {
    for (const ComparisonTable& table : comparison.tables)
      RenderModelChart(
          out.Staged(table.fabric == 0 ? "models"
                                       : "models_fabric_" + std::to_string(table.fabric)),
          table);
  } catch (const InputError& error) {
    control.Log(std::string("no charts: ") + error.what());
  }
}

}  // namespace

OptionTable CompareTable(CompareToolOptions& options) {
  std::vector<Option> all = SplitOptions(options);
  for (const Option& option : DrawOptions(options)) all.push_back(option);
  for (const Option& option : FitTable(options.fit).options)
    if (!kOfCells.contains(option.key)) all.push_back(option);
  return {
      .tool = "drape_compare",
      .summary =
          "which model of a fabric the data need: fits of the same images, scored on the "
          "same held-out drapes",
      .example =
          "drape_compare --config=configs/studies/compare/quick.json --data=DIR --out=out/compare",
      .notes =
          "files: comparison.md, comparison.csv, comparison.json; of each fabric, model and seed "
          "fabric_<N>/<model>/seed_<K>\n  with the files of drape_fit and prediction.json, and "
          "fabric_<N>/split_<K>.json\n"
          "models_fabric_<N>.png and .svg, models.png and .svg for all fabrics: a line a model, "
          "its errors and the rollouts of its fit\n"
          "chosen is the simplest model (isotropic < linear < bend < bend_rows < scales < columns "
          "< homo < heter < elements < bdp < bayes) whose\n  held-out energy score "
          "of the features is within\n  one standard error of the best; that of the paired "
          "differences over held-out captures, taken as independent\n"
          "Ctrl-C or a kill loses no cell that is done: the same command goes on to the same "
          "numbers\n",
      .options = std::move(all)};
}

CompareResult RunCompareTool(const CompareToolOptions& options, const RunControl& control) {
  const ComparisonJob job = MakeJob(options);
  const OutputFolder out(options.out);
  CompareResult result{RunComparison(job, control), ""};
  if (result.run.cancelled) return result;
  WriteComparison(out.Staged(""), result.run.comparison, job.settings);
  RenderCharts(out, result.run.comparison, control);
  out.Publish();
  result.text = ComparisonText(result.run.comparison);
  return result;
}

}  // namespace drape
