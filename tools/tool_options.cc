// SPDX-License-Identifier: Apache-2.0
#include "tools/tool_options.h"

#include "tools/backend_option.h"
#include "tools/common_options.h"

namespace drape {

std::vector<Option> ClothOptions(SceneInput& scene) {
  return {
      {.key = "mesh",
       .value = &scene.mesh,
       .doc = "cloth: an OBJ file, disc:N for a built-in disc of N vertices, or "
              "strip:LENGTHxWIDTHxALONG [m, m, edges]",
       .is_path = true,
       .words = {"disc:", "strip:"}},
      {.key = "material",
       .value = &scene.material,
       .doc = "a material file; FILE#name picks one of several in it",
       .is_path = true,
       .required = true},
      LawOption(scene.law),
  };
}

std::vector<Option> CameraOptions(CameraInput& camera) {
  return {
      {.key = "camera", .value = &camera.kind,
       .doc = "orthographic is what the published images obey",
       .choices = {"orthographic", "pinhole"}},
      {.key = "camera_width", .value = &camera.width, .doc = "width of the silhouette",
       .unit = "px", .least = 16, .most = 8192},
      {.key = "camera_height", .value = &camera.height, .doc = "height of the silhouette",
       .unit = "px", .least = 16, .most = 8192},
      {.key = "camera_cx", .value = &camera.cx,
       .doc = "column of the support's centre; none: the image's centre", .unit = "px"},
      {.key = "camera_cy", .value = &camera.cy,
       .doc = "row of the support's centre; none: the image's centre", .unit = "px"},
      {.key = "camera_scale", .value = &camera.scale, .doc = "magnification, orthographic only",
       .unit = "px/m", .least = 0, .above_least = true},
  };
}

namespace {

std::vector<Option> SceneOptions(SceneInput& scene) {
  std::vector<Option> options = ClothOptions(scene);
  options.push_back({.key = "start", .value = &scene.start,
                     .doc = "first shape: flat, or a start shape or state file",
                     .is_path = true, .words = {"flat"}});
  return options;
}

template <class... Lists>
std::vector<Option> Concatenate(Lists... lists) {
  std::vector<Option> all;
  (all.insert(all.end(), lists.begin(), lists.end()), ...);
  return all;
}

}  // namespace

OptionTable SimulateTable(SimulateOptions& options) {
  const std::vector<Option> scene = {
      {.key = "scene", .value = &options.scene.scene,
       .doc = "what acts and who is held: cusick, or a scene file (configs/scenes)",
       .is_path = true, .words = {"cusick"}},
  };
  const std::vector<Option> steps = {
      {.key = "integrator", .value = &options.integrator,
       .doc = "steps in time, steps and then Newton to rest, or Newton from --start",
       .choices = {"dynamic", "hybrid", "static"}},
      {.key = "h", .value = &options.h, .doc = "time step", .unit = "s", .least = 0, .most = 10,
       .above_least = true},
      {.key = "steps", .value = &options.steps, .doc = "number of time steps", .least = 0,
       .most = 1000000},
      BackendOption(options.backend),
  };
  const std::vector<Option> files = {
      {.key = "image", .value = &options.image,
       .doc = "silhouette (JPEG or PNG) to compare the drape with", .is_path = true},
      {.key = "dump_steps", .value = &options.dump_steps,
       .doc = "write state_<step>.json after these steps; 0 is the start", .least = 0},
      {.key = "gradient_weights", .value = &options.gradient_weights,
       .doc = "file {\"w\": [3 a vertex]}: writes gradient.json of L = sum of w*x at the end",
       .is_path = true},
      OutOption(options.out),
  };
  return {
      .tool = "drape_simulate",
      .summary = "one drape of a fabric over the support of the Cusick test, or on another scene",
      .example =
          "drape_simulate --mesh=disc:1200 --material=configs/fabrics/cotton_blue.json "
          "--steps=100 --dump_steps=10,100 --out=out/drape",
      .notes =
          "files: summary.json (outcome, drape coefficient, folds, force residual, metrics), "
          "drape.obj, silhouette.png,\n  state_<step>.json, state_rest.json (hybrid, static), "
          "gradient.json; they replace those of an earlier run together, at the end\n"
          "exit code 3: the computation failed (see outcome and status in summary.json); what "
          "is written is the last good shape\n",
      .options = Concatenate(SceneOptions(options.scene), scene, steps,
                             AccuracyOptions(options.accuracy), CameraOptions(options.camera),
                             files),
      .given = &options.accuracy.given};
}

OptionTable CheckTable(CheckToolOptions& options) {
  const std::vector<Option> checks = {
      {.key = "h", .value = &options.check.h, .doc = "time step of the rollouts", .unit = "s",
       .least = 0, .most = 10, .above_least = true},
      {.key = "steps", .value = &options.check.steps, .doc = "time steps of the rollouts",
       .least = 1, .most = 1000},
      {.key = "seed", .value = &options.check.seed, .doc = "of the directions and of the noise",
       .least = 0},
      {.key = "noise", .value = &options.check.noise,
       .doc = "random offset of the start, which breaks symmetry", .unit = "mean edge lengths",
       .least = 0, .most = 1},
  };
  return {
      .tool = "drape_check",
      .summary = "checks forces, energies and derivatives of a scene and prints a table",
      .example = "drape_check --config=configs/check.json --law=reference",
      .notes = "exit code 1: a check failed\n",
      .options = Concatenate(SceneOptions(options.scene), checks)};
}

}  // namespace drape
