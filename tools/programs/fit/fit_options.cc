// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/tool_options.h"
#include "tools/programs/fit/fit_tool.h"

namespace drape {
namespace {

std::vector<Option> InputOptions(FitToolOptions& options) {
  FitJob& job = options.job;
  return {
      {.key = "images",
       .value = &options.images,
       .doc = "silhouettes of one fabric (JPEG or PNG), fitted jointly: files, folders, patterns",
       .is_path = true},
      {.key = "lab_tests",
       .value = &options.tests,
       .doc =
           "cantilever and tensile tests of the fabric (JSON, configs/README.md), fitted alone or "
           "jointly with the images: files, folders, patterns",
       .is_path = true},
      {.key = "material",
       .value = &job.material,
       .doc = "start tables: a material file; FILE#name picks one of several in it",
       .is_path = true,
       .required = true},
      {.key = "density",
       .value = &job.density,
       .doc =
           "areal density of the fabric, as weighed; 0: that of the start tables, with --data the "
           "published one",
       .unit = "kg/m2",
       .least = 0,
       .most = 10},
      {.key = "ground_truth",
       .value = &job.truth,
       .doc = "tables that the images were made with, to be compared with the result",
       .is_path = true},
      {.key = "model",
       .value = &job.model,
       .doc = "homo: one table for the whole cloth; heter: then tables that vary over it; bayes: "
              "then how sure the tables are; bdp: then how far each face and hinge scatters about "
              "them, as in Gong et al. 2024",
       .choices = {"homogeneous", "heterogeneous", "bayes", "bdp"}},
      MeshOption("mesh", &job.mesh,
                 "cloth: an OBJ file, or disc:N for a built-in disc of N vertices"),
      MeshOption("coarse_mesh", &job.coarse_mesh, "cloth of the seed grid"),
      LawOption(job.law),
      {.key = "camera",
       .value = &job.camera,
       .doc = "orthographic is what the published images obey",
       .choices = {"orthographic", "pinhole"}},
      {.key = "centre",
       .value = &job.centre,
       .doc = "where the support's centre is: in the image's centre, or found from the outline",
       .choices = {"nominal", "outline"}},
      OutOption(options.out),
      {.key = "resume",
       .value = &job.resume,
       .doc =
           "go on from out/checkpoint.json to the same answer; fields and posteriors begin anew"},
  };
}

std::vector<Option> DataOptions(FitToolOptions& options) {
  return {
      {.key = "data",
       .value = &options.data.folder,
       .doc = "folder of the published data set, whose drapes are fitted in place of images",
       .is_path = true},
      {.key = "fabric",
       .value = &options.data.fabric,
       .doc = "of --data: its number; 0: none",
       .least = 0,
       .most = 9999},
      {.key = "samples", .value = &options.data.samples, .doc = "of --data, like 1,3-5; none: all"},
      {.key = "captures", .value = &options.data.captures, .doc = "of --data, like 1,3; none: all"},
      {.key = "face",
       .value = &options.data.face,
       .doc = "of --data, which face lies up: captures 1 and 2 are up, 3 and 4 down",
       .choices = {"up", "down", "both"}},
      {.key = "data_source",
       .value = &options.targets,
       .doc = "of --data: silhouettes, or the outlines of the published meshes, whose z adds "
              "nothing to them (straight flaps under the outline)",
       .choices = {"silhouettes", "meshes"}},
  };
}

std::vector<Option> FieldOptionList(FitToolOptions& options) {
  FieldOptions& fields = options.job.fields;
  return {
      {.key = "field_basis",
       .value = &options.field_basis,
       .doc = "model heter: each face and hinge on its own, or smooth random fields",
       .choices = {"elements", "modes"}},
      {.key = "field_groups",
       .value = &options.field_groups,
       .doc = "model heter, what varies: a factor on all stretch entries and one on all bend "
              "entries, one of the two only, or each entry on its own",
       .choices = {"scales", "stretch", "bend", "entries"}},
      {.key = "field_sigma",
       .value = &fields.sigma,
       .doc = "model heter: standard deviation of a log factor over the cloth, in the prior",
       .least = 0,
       .above_least = true},
      {.key = "field_length",
       .value = &fields.length,
       .doc = "field_basis modes: correlation length",
       .unit = "m",
       .least = 0,
       .above_least = true},
      {.key = "field_modes",
       .value = &fields.modes,
       .doc = "field_basis modes: how many",
       .least = 1,
       .most = 1000},
      {.key = "field_iterations",
       .value = &fields.iterations,
       .doc = "model heter: iterations of Ceres for the fields, in each attempt",
       .least = 0,
       .most = 10000},
      {.key = "field_restarts",
       .value = &fields.hops,
       .doc = "model heter: attempts after the first, each from a neighbouring branch of the best",
       .least = 0,
       .most = 1000},
  };
}

std::vector<Option> PosteriorOptionList(PosteriorOptions& posterior) {
  return {
      {.key = "specimens",
       .value = &posterior.specimen,
       .doc =
           "models bayes, bdp: the specimen of each image, from 1; none: each image its own, with "
           "--data each sample",
       .least = 1,
       .most = 1000},
      {.key = "specimen_stretch_sigma",
       .value = &posterior.specimen_stretch_sigma,
       .doc = "model bayes: how specimens of the fabric differ, standard deviation of a log factor "
              "on all stretch entries",
       .least = 0},
      {.key = "specimen_bend_sigma",
       .value = &posterior.specimen_bend_sigma,
       .doc = "the same on all bend entries",
       .least = 0},
      {.key = "element_sigma",
       .value = &posterior.element_sigma,
       .doc = "model bdp: how far faces and hinges scatter, most likely standard deviation of a "
              "log factor in the prior",
       .least = 0,
       .most = 3,
       .above_least = true},
      {.key = "estimate_sigma",
       .value = &posterior.estimate_sigma,
       .doc = "models bayes, bdp: sigma_px from what the mode leaves unexplained"},
      {.key = "posterior_angles",
       .value = &posterior.angles,
       .doc = "models bayes, bdp: rays of the outline, no nearer than they are independent",
       .least = 31,
       .most = 3600},
      {.key = "posterior_samples",
       .value = &posterior.draws,
       .doc = "models bayes, bdp: draws behind the posterior, even",
       .least = 2,
       .most = 10000},
      {.key = "posterior_rank",
       .value = &posterior.rank,
       .doc = "model bayes: directions whose correlations are free beside those of Laplace",
       .least = 0,
       .most = 1000},
      {.key = "posterior_iterations",
       .value = &posterior.iterations,
       .doc = "models bayes, bdp: iterations of Ceres for the posterior",
       .least = 0,
       .most = 10000},
      {.key = "elbo_samples",
       .value = &posterior.elbo_samples,
       .doc = "models bayes, bdp: draws by which the evidence and k are judged",
       .least = 25,
       .most = 100000},
  };
}

std::vector<Option> GridOptions(InitialGuessOptions& grid) {
  return {
      {.key = "initial_stretch",
       .value = &grid.stretch,
       .doc = "seed grid: factors on all stretch entries",
       .least = 0,
       .above_least = true},
      {.key = "initial_bend",
       .value = &grid.bend,
       .doc = "seed grid: factors on all bend entries",
       .least = 0,
       .above_least = true},
      {.key = "initial_lifts",
       .value = &grid.lifts,
       .doc = "seed grid: how high the flaps of the seed shapes stand",
       .least = 0,
       .most = 1,
       .above_least = true},
      {.key = "initial_time_step",
       .value = &grid.h,
       .doc = "seed grid: time step",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      {.key = "initial_steps",
       .value = &grid.steps,
       .doc = "seed grid: time steps of each trial",
       .least = 1,
       .most = 100000},
  };
}

std::vector<Option> FitStageOptions(FitToolOptions& options) {
  StagedFitOptions& fit = options.job.fit;
  return {
      {.key = "candidates_per_round",
       .value = &fit.keep,
       .doc = "branches fitted in each round, side by side; a first number above the count of "
              "grid_stretch x grid_bend adds factors between those of the grid",
       .least = 1,
       .most = 1000},
      {.key = "iterations",
       .value = &fit.iterations,
       .doc = "iterations of Ceres for each branch of a round",
       .least = 1,
       .most = 10000},
      {.key = "num_parameters",
       .value = &options.parameters,
       .doc = "free numbers: 2 scales, 7 column scales, or all 39 entries; 1 scale of bend or 3 of "
              "its rows, "
              "with stretch as grid_stretch has it",
       .choices = {"1", "2", "3", "7", "39"}},
      {.key = "prior_sigma",
       .value = &fit.prior_sigma,
       .doc = "standard deviation of each log factor about its seed",
       .least = 0,
       .above_least = true},
      {.key = "sigma_px",
       .value = &fit.sigma_px,
       .doc = "standard deviation of the outline",
       .unit = "px",
       .least = 0,
       .above_least = true},
      {.key = "angles",
       .value = &fit.angles,
       .doc = "rays at which the outline is compared",
       .least = 31,
       .most = 3600},
      {.key = "solve",
       .value = &options.integrator,
       .doc = "fit the drape at rest, or the shape after the steps",
       .choices = {"static", "dynamic"}},
      {.key = "warm_restart",
       .value = &fit.warm_restart,
       .doc = "integrator dynamic: trials start from the last accepted drape, not from the seed's"},
      {.key = "max_outline_change",
       .value = &fit.max_outline_change,
       .doc = "a step that is predicted to move the outline further is refused",
       .unit = "px",
       .least = 0,
       .above_least = true},
      {.key = "max_jump",
       .value = &fit.max_jump,
       .doc = "a drape whose vertices lie further from their prediction is another branch and "
              "refused",
       .unit = "m",
       .least = 0,
       .above_least = true},
      {.key = "settle_time_step",
       .value = &fit.settle_h,
       .doc = "time step that calms a seed",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      {.key = "settle_steps",
       .value = &fit.settle_steps,
       .doc = "time steps that calm a seed",
       .least = 0,
       .most = 100000},
      {.key = "recheck_steps",
       .value = &options.job.evaluation_steps,
       .doc = "time steps of settle_h after which the fitted drape is judged again",
       .least = 0,
       .most = 100000},
      {.key = "min_relative_stiffness",
       .value = &options.job.floor,
       .doc = "start entries under this share of their column's largest are raised to it: a "
              "negative one is else refused (smooth law), and a zero stays zero",
       .least = 0,
       .most = 1},
      {.key = "table_form",
       .value = &options.tables,
       .doc = "form of the start tables: linear: their means over strain and curvature, isotropic: "
              "and over directions; kept by 2 free numbers, linear by 7 too",
       .choices = {"given", "linear", "isotropic"}},
      BackendOption(options.job.backend),
      ThreadsOption(options.job.threads),
  };
}

}  // namespace

OptionTable FitTable(FitToolOptions& options) {
  std::vector<Option> all = InputOptions(options);
  for (const Option& option : DataOptions(options)) all.push_back(option);
  for (const Option& option : AccuracyOptions(options.accuracy)) all.push_back(option);
  for (const Option& option : FitStageOptions(options)) all.push_back(option);
  for (const Option& option : FieldOptionList(options)) all.push_back(option);
  for (const Option& option : PosteriorOptionList(options.job.posterior)) all.push_back(option);
  for (const Option& option : GridOptions(options.job.fit.grid)) all.push_back(option);
  return {
      .tool = "drape_fit",
      .summary =
          "finds the stretch and bend stiffness of a fabric from silhouettes of its drapes, "
          "from mechanical tests, or from both",
      .example = "drape_fit --config=configs/programs/fit.json --images=drape.jpg --out=out/fit",
      .notes =
          "files: summary.json, material.json and, of each image, fit_<image>.png, "
          "drape_<image>.obj, start_<image>.json;\n"
          "  model heter also material_homogeneous.json, field_<kind>.png, known_<kind>.png;\n"
          "  models bayes and bdp also material_homogeneous.json, base.json, posterior.json;\n"
          "  they replace those of an earlier run together, at the end; checkpoint.json and "
          "fit.log while it runs\n"
          "exit code 3: nothing could be fitted (see summary.json)\n"
          "Ctrl-C writes the best fit so far and keeps the checkpoint for --resume\n",
      .options = std::move(all),
      .given = &options.accuracy.given};
}

}  // namespace drape
