// SPDX-License-Identifier: Apache-2.0
#include "physics/util/errors.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/simulate/simulate_tool.h"

namespace drape {

std::string ApplyAccuracy(SimulateOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  if (options->scene.scene != "cusick")
    throw InputError("option 'accuracy'", "found the scene " + options->scene.scene +
                                              ", expected cusick: the table is of the drape test");
  const bool has_solve = choice.given.contains("solve");
  if (has_solve && options->solve == "static")
    throw InputError("option 'accuracy'", "found solve = static, expected hybrid");
  const AccuracyRow row = PickAccuracy(choice, has_solve ? options->solve : "");
  AccuracyFilling filling(choice);
  filling.Set("mesh", row.mesh, &options->scene.mesh);
  filling.Set("solve", row.integrator, &options->solve);
  filling.Set("time_step", row.h, &options->h);
  filling.Set("steps", row.steps, &options->steps);
  return filling.Line(row);
}

namespace {

std::vector<Option> FileOptions(SimulateOptions& options) {
  return {
      {.key = "image",
       .value = &options.image,
       .doc = "silhouette (JPEG or PNG) to compare the drape with",
       .is_path = true},
      {.key = "dump_steps",
       .value = &options.dump_steps,
       .doc = "steps whose states are written to state_<step>.json; 0: the start",
       .least = 0},
      {.key = "gradient_weights",
       .value = &options.gradient_weights,
       .doc = "needs solve = dynamic: file {\"w\": [x0, y0, z0, x1, …]}, one flat list of three "
              "numbers for each vertex; writes the gradient of L = sum of w*x at the end by each "
              "number of the material file (convention mechanical) to gradient.json",
       .is_path = true},
      {.key = "geometry",
       .value = &options.geometry,
       .doc =
           "vtu: further files of the drape with strain, tension and stiffness of each face, for "
           "ParaView; with dump_steps a series drape.pvd"},
      OutOption(options.out),
  };
}

}  // namespace

OptionTable SimulateTable(SimulateOptions& options) {
  const std::vector<Option> steps = {
      {.key = "solve",
       .value = &options.solve,
       .doc = "method: time steps (dynamic), time steps followed by Newton's method (hybrid), or "
              "Newton's method from --start (static)",
       .choices = {"dynamic", "hybrid", "static"}},
      TimeStepOption(options.h),
      {.key = "steps",
       .value = &options.steps,
       .doc = "number of time steps",
       .least = 0,
       .most = 1000000},
      BackendOption(options.backend),
  };
  return {
      .tool = "drape_simulate",
      .summary =
          "simulates one drape of a fabric, over the support of the Cusick test or in another "
          "scene",
      .example =
          "drape_simulate --mesh=disc:1200 --fabric=configs/fabrics/cotton_blue.json "
          "--steps=100 --dump_steps=10,100 --out=out/drape",
      .notes =
          "files: summary.json (outcome, drape coefficient, folds, force residual, metrics), "
          "drape.obj, silhouette.png, state_<step>.json, state_rest.json (hybrid and static), "
          "gradient.json, with --geometry drape.vtu. They replace the files of an "
          "earlier run together, at the end.\n"
          "exit code 3: the computation failed (outcome and status in summary.json); the files "
          "show the last good shape\n",
      .options = Concatenate(
          Grouped("cloth and scene", SceneOptions(options.scene)),
          Grouped("simulation", Concatenate(steps, AccuracyOptions(options.accuracy))),
          Grouped("camera", CameraOptions(options.camera)), Grouped("files", FileOptions(options))),
      .common = {"mesh", "fabric", "specimen", "support", "start", "scene", "solve", "time_step",
                 "steps", "accuracy", "image", "out"},
      .given = &options.accuracy.given};
}

}  // namespace drape
