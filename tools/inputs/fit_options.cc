// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/fit_options.h"

#include <utility>

#include "physics/util/errors.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

std::vector<Option> DataOptions(FitToolOptions& options) {
  FitData& data = options.data;
  return {
      PathOption("images", &options.images,
                 "silhouettes of one fabric, fitted jointly: files, folders, patterns, "
                 "samples.csv#fabric"),
      {.key = "each",
       .value = &options.each,
       .doc =
           "a fit of its own for each image, as many at a time as threads, each in its folder of "
           "out; each.csv and each.json have a row for each; the same command continues"},
      PathOption(
          "lab_tests", &options.lab_tests,
          "cantilever and tensile tests (JSON, U3M 1.1; configs/README.md), alone or with images"),
      PathOption("experiment", &data.experiment,
                 "file of markers, points, depth maps, motions (configs/README.md), alone"),
      FabricOption(&data.material),
      Usual(NumberOption("density", &data.density, 0, 10,
                         "areal density of the fabric, as weighed; 0: that of lab_tests, the data "
                         "set or `fabric`",
                         "kg/m2"),
            0.01, 1.5),
      PathOption("ground_truth", &data.ground_truth,
                 "tables that the images were made with, to be compared with the result"),
      NumberOption(
          "specimens", &data.specimens, 1, 1000,
          "models bayes, bdp: the specimen of each image, from 1; empty: each image shows its "
          "own, with --data each sample"),
      OutOption(options.out),
      {.key = "resume",
       .value = &options.resume,
       .doc = "continue from out/checkpoint.json to the identical result; fields and posteriors "
              "start again",
       .repeated = false},
  };
}

std::vector<Option> SelectionOptions(FitToolOptions& options) {
  FitSelection& selection = options.selection;
  return {
      PathOption("data", &selection.folder,
                 "folder of the published data set, whose drapes are fitted in place of images"),
      NumberOption("data_fabric", &selection.fabric, 0, 9999,
                   "with --data: number of the fabric; 0: not given"),
      PlainOption("samples", &selection.samples, "with --data: samples, like 1,3-5; empty: all"),
      PlainOption("captures", &selection.captures, "with --data: captures, like 1,3; empty: all"),
      ChoiceOption("face", &selection.face, {"up", "down", "both"},
                   "with --data: the face that lies up; captures 1 and 2 are up, 3 and 4 down"),
      EnumOption("data_source", options.data.source,
                 "with --data: silhouettes, or the outlines of the published meshes, whose z has "
                 "no further information (straight flaps under the outline)"),
  };
}

Option PriorOption(FitSpec& spec) {
  return PathOption(
      "prior", &spec.prior,
      "model bayes: space.json of drape_space, whose population of fabrics is the prior "
      "of the posterior; empty: about the initial guess, by prior_sigma");
}

}  // namespace

OptionTable FitTable(FitToolOptions& options) {
  FitSpec& spec = options.spec;
  return {
      .tool = "drape_fit",
      .summary =
          "finds the stretch and bend stiffness of a fabric from silhouettes of its drapes, "
          "from laboratory tests, or from both",
      .example = "drape_fit --config=configs/programs/fit.json --images=drape.jpg --out=out/fit",
      .notes =
          "files: summary.json, material.json and, for each image, fit_<image>.png, "
          "drape_<image>.obj, start_<image>.json; model heterogeneous also "
          "material_homogeneous.json and fields.json, which drape_report draws; models bayes "
          "and bdp also material_homogeneous.json, base.json, posterior.json; they replace those "
          "of an earlier run together, at the end; checkpoint.json, fit.log and "
          "outlines.json, the best outlines so far, while it runs\n"
          "exit code 3: nothing could be fitted (see summary.json)\n"
          "Ctrl-C writes the best fit so far and keeps the checkpoint for --resume\n",
      .options = Concatenate(
          Grouped("data and results", DataOptions(options)),
          Grouped("published data set (--data)", SelectionOptions(options)),
          Grouped(
              "simulation",
              Concatenate(AccuracyOptions(options.accuracy), FieldOptionList(spec),
                          std::vector{BackendOption(spec.backend), ThreadsOption(spec.threads)})),
          Grouped("images and outlines", FieldOptionList(spec.observation)),
          Grouped("search and optimisation", FieldOptionList(spec.stages)),
          Grouped("model heterogeneous", FieldOptionList(spec.fields)),
          Grouped("models bayes and bdp",
                  Concatenate(FieldOptionList(spec.posterior), std::vector{PriorOption(spec)}))),
      .common = {"images", "specimen", "image_width_mm", "warp", "lab_tests", "experiment",
                 "fabric", "density", "model", "mesh", "accuracy", "num_parameters", "threads",
                 "backend", "out", "resume"},
      .given = &options.accuracy.given};
}

void CheckRounds(const StagedFitOptions& stages) {
  if (stages.candidates_per_round.size() != stages.iterations.size()) {
    throw InputError("option 'iterations'", "found " + std::to_string(stages.iterations.size()) +
                                                " values, expected " +
                                                std::to_string(stages.candidates_per_round.size()) +
                                                ", as many rounds as 'candidates_per_round' has");
  }
}

FitSpec MakeFitSpec(const FitToolOptions& options) {
  FitSpec spec = options.spec;
  ParseWarp(spec.observation.warp);
  CheckRounds(spec.stages);
  if (spec.posterior.draws % 2 != 0) {
    throw InputError("option 'posterior_samples'",
                     "found " + std::to_string(spec.posterior.draws) + ", expected an even number");
  }
  spec.threads = CountThreads(spec.threads);
  return spec;
}

}  // namespace drape
