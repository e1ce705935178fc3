// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <utility>

#include "losses/dataset/dataset.h"
#include "physics/util/errors.h"
#include "solver/studies/comparison/comparison.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

// The options of drape_compare.
struct CompareToolOptions {
  CompareToolOptions() {
    fit.spec.fields.basis = FieldBasis::kModes;  // elements do not carry over
    job.models = {"homogeneous", "heterogeneous", "bdp", "bayes"};
    job.seeds = {1, 2, 3};
  }

  ComparisonJob job;
  StudyOptions study;
  FitToolOptions fit;                                          // of all runs
  std::string fabrics = "1-5", train_captures, face = "both";  // ParseIndexList, ClothFace
};

OptionTable CompareTable(CompareToolOptions& options);

// Options that change no number of a run, or that its name holds.
const std::set<std::string> kFreeOfRuns = {"data_fabric", "fabric", "models", "seeds", "threads"};

std::vector<Option> SplitOptions(CompareToolOptions& options) {
  ComparisonJob& job = options.job;
  return {
      {.key = "data",
       .value = &job.data,
       .doc = "folder of the published data set",
       .is_path = true,
       .required = true},
      PlainOption("data_fabric", &options.fabrics, "fabrics of the data set, as in 1,3-5"),
      PlainOption(
          "models", &job.models,
          "models to compare: homogeneous, heterogeneous, bdp and bayes of drape_fit; "
          "isotropic and linear tables; scales and columns (2 and 7 parameters); bend and "
          "bend_rows (1 and 3 parameters, with the initial guess of stretch); elements (the "
          "other basis of the heterogeneous model); generative (distributions of eight numbers "
          "of a specimen, learned from the drapes of the training samples)"),
      NumberOption(
          "seeds", &job.seeds, 0, kUnlimited,
          "random seeds, each for one repetition: of the split that all models share, and of "
          "the samples of posteriors and drapes"),
      FabricOption(&job.materials),
      NumberOption("train", &job.train, 1, 9999,
                   "number of training samples of each fabric; the others are held out"),
      PlainOption("train_captures", &options.train_captures,
                  "captures of the training samples to fit, as in 1,3; none: all"),
      ChoiceOption("face", &options.face, {"up", "down", "both"},
                   "face of the cloth that lies up: captures 1 and 2 show it up, 3 and 4 down"),
  };
}

std::vector<Option> DrawOptions(CompareToolOptions& options) {
  return {
      NumberOption("draws", &options.job.draws, 4, 4096,
                   "number of drapes predicted by each fit, shared equally by the held-out faces"),
      PlainOption("calibrate", &options.job.calibrate,
                  "fit a factor on the bend stiffness for each face, so that simulated drapes look "
                  "like the training captures"),
  };
}

ComparisonJob MakeJob(const CompareToolOptions& options) {
  ComparisonJob job = options.job;
  job.fit = MakeFitSpec(options.fit);
  job.provenance = MakePartProvenance;
  job.fabrics = ParseIndexList(options.fabrics, "option 'data_fabric'");
  if (job.fabrics.empty())
    throw InputError("option 'data_fabric'", "is empty, expected at least one fabric");
  job.train_captures = ParseIndexList(options.train_captures, "option 'train_captures'");
  job.face = ParseClothFace(options.face);
  job.out = options.study.out;
  job.list = options.study.list;
  LearningOptions& learning = job.learning;
  learning.pool.mesh = job.fit.mesh;
  learning.fit.threads = job.fit.threads;
  if (learning.pool_file.empty()) learning.pool_file = job.out + "/pool.json";
  CompareToolOptions copy = options;
  job.settings = OptionSettings(CompareTable(copy), kFreeOfRuns);
  return job;
}

ToolOutcome RunComparison(const CompareToolOptions& options, const RunControl& control) {
  CheckShare(options.study);
  const Comparison comparison = MakeComparison(MakeJob(options), control);
  if (control.cancelled()) return {.cancelled = true};
  return RunStudyProgram(comparison.study, options.study, control, comparison.summarise);
}

OptionTable CompareTable(CompareToolOptions& options) {
  return {
      .tool = "drape_compare",
      .summary =
          "compares models of a fabric: fits to the same images, scored on the same held-out "
          "drapes",
      .example =
          "drape_compare --config=configs/studies/compare/quick.json --data=DIR --out=out/compare",
      .notes =
          "files: comparison.md, comparison.csv, comparison.json; for each fabric, and for all, "
          "models….svg (error and rollouts of each model) and held_out….svg (error on other "
          "samples against free numbers and against time), also as PNG; for each fabric, model "
          "and seed, fabric_<N>/<model>/seed_<K> with the files of drape_fit, and "
          "fabric_<N>/split_<K>.json\n"
          "The chosen model is the simplest one (isotropic < linear < bend < bend_rows < scales < "
          "columns < homogeneous < heterogeneous < elements < bdp < bayes < generative) whose "
          "held-out energy score of the features is within one standard error of the best. The "
          "standard error is that of the paired differences over held-out captures, taken as "
          "independent.\n"
          "After Ctrl-C or a kill the same command continues with the unfinished runs and gives "
          "the identical result.\n",
      .options =
          Concatenate(Grouped("comparison", SplitOptions(options)),
                      Grouped("prediction and results",
                              Concatenate(PoolOptionRows(options.job.learning),
                                          DrawOptions(options), StudyOptionList(options.study))),
                      FitOptionsOfCells(options.fit)),
      .common = {"data", "data_fabric", "fabric", "models", "seeds", "train", "face", "mesh",
                 "draws", "calibrate", "threads", "backend", "share", "out"}};
}

}  // namespace

int CompareMain(int argc, char** argv) { return ToolMain(argc, argv, CompareTable, RunComparison); }

}  // namespace drape
