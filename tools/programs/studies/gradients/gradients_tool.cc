// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/gradients/gradients_tool.h"

#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/backend_option.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/studies/gradients/gradients_report.h"

namespace drape {
namespace {

SceneInput MakeInput(const GradientsOptions& options, const std::string& law) {
  SceneInput input;
  input.mesh = options.mesh;
  input.material = options.material;
  input.base = options.base;
  input.law = law;
  return input;
}

std::vector<Option> ClothOptionList(GradientsOptions& options) {
  return {MeshOption("mesh", &options.mesh, "cloth"),
          {.key = "material",
           .value = &options.material,
           .doc = "material file",
           .is_path = true,
           .required = true},
          BaseOption(options.base)};
}

std::vector<Option> SurveyOptions(GradientSurveyOptions& survey) {
  return {{.key = "start_seed",
           .value = &survey.start_seed,
           .doc = "random seed of the start shape",
           .least = 0,
           .most = 1000000000},
          {.key = "hem_rms",
           .value = &survey.hem_rms,
           .doc = "root mean square height of the start shape at the hem",
           .unit = "m",
           .least = 0,
           .most = 0.05,
           .above_least = true},
          {.key = "direction_seed",
           .value = &survey.direction_seed,
           .doc = "random seed of the direction in the 39 log entries",
           .least = 0,
           .most = 1000000000},
          {.key = "horizons",
           .value = &survey.horizons,
           .doc = "numbers of time steps",
           .least = 1,
           .most = 100000},
          {.key = "time_steps",
           .value = &survey.time_steps,
           .doc = "time steps",
           .unit = "s",
           .least = 0,
           .most = 10,
           .above_least = true},
          {.key = "horizon_step",
           .value = &survey.horizon_step,
           .doc = "step of the differences at each horizon, in log units",
           .least = 0,
           .most = 1,
           .above_least = true},
          {.key = "sweep_horizon",
           .value = &survey.sweep_horizon,
           .doc = "number of time steps of 0.1 s for which the step of the differences is swept",
           .least = 1,
           .most = 100000},
          {.key = "fold_starts",
           .value = &survey.fold_starts,
           .doc = "number of branches followed towards softer bend until they end; their seeds "
                  "begin at start_seed",
           .least = 0,
           .most = 1000}};
}

}  // namespace

OptionTable GradientsTable(GradientsOptions& options) {
  return {
      .tool = "drape_gradients",
      .summary =
          "studies where gradients of a drape fail: differences, long horizons, kinks and the ends "
          "of branches",
      .example = "drape_gradients --config=configs/studies/gradients.json --out=out/gradients",
      .notes =
          "files: summary.json, report.md, differences.png, horizons.png, fold.png\n"
          "Ctrl-C writes the results so far.\n",
      .options =
          Concatenate(ClothOptionList(options), SurveyOptions(options.survey),
                      std::vector{BackendOption(options.survey.backend), OutOption(options.out)})};
}

GradientStudy RunGradients(const GradientsOptions& options, const RunControl& control) {
  std::vector<StudiedCloth> cloths;
  for (const char* law : {"smooth", "reference"}) {
    LoadedScene scene = LoadScene(MakeInput(options, law));
    cloths.push_back({law, std::move(scene.model), std::move(scene.material.field)});
  }
  const OutputFolder out(
      options.out, {"summary.json", "report.md", "differences.png", "horizons.png", "fold.png"});
  GradientStudy found = SurveyGradients(cloths, options.survey, control);
  WriteGradientReport(out, &found);
  out.Publish();
  return found;
}

namespace {

ToolOutcome Run(const GradientsOptions& options, const RunControl& control) {
  const GradientStudy study = RunGradients(options, control);
  std::string text;
  for (const TextTable& table : MakeGradientTables(study)) {
    if (!text.empty()) text += '\n';
    text += table.Aligned();
  }
  if (!study.note.empty()) text += '\n' + study.note;
  return {.text = std::move(text), .cancelled = study.cancelled};
}

}  // namespace

int GradientsMain(int argc, char** argv) { return ToolMain(argc, argv, GradientsTable, Run); }

}  // namespace drape
