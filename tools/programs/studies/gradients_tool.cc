// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "solver/studies/gradients/gradient_study.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

// The options of drape_gradients.
struct GradientsOptions {
  std::string mesh = "disc:300";
  std::string fabric = kBuiltInName;  // ReadMaterial
  GradientStudyOptions gradients;
  StudyOptions study;
};

OptionTable GradientsTable(GradientsOptions& options) {
  GradientStudyOptions& gradients = options.gradients;
  const std::vector<Option> rows = {
      MeshOption("mesh", &options.mesh, "cloth"),
      FabricOption(&options.fabric),
      NumberOption("start_seed", &gradients.start_seed, 0, 1000000000,
                   "random seed of the start shape"),
      NumberOption("horizons", &gradients.horizons, 1, 100000, "numbers of time steps"),
      PositiveOption("time_steps", &gradients.time_steps, 10, "time steps", "s"),
      NumberOption(
          "fold_starts", &gradients.fold_starts, 0, 1000,
          "number of branches followed towards softer bend until they end; their seeds begin at "
          "start_seed")};
  return {.tool = "drape_gradients",
          .summary =
              "studies where gradients of a drape fail: differences, long horizons, kinks "
              "and the ends of branches",
          .example = "drape_gradients --config=configs/studies/gradients.json --out=out/gradients",
          .notes =
              "files: gradients.json, report.md, and as .svg and .png differences, horizons "
              "and fold; cells/ has the finished runs, from which the same command "
              "continues\n",
          .options = Concatenate(rows, StudyOptionList(options.study))};
}

ToolOutcome RunGradients(const GradientsOptions& options, const RunControl& control) {
  std::vector<StudiedCloth> cloths;
  const ReadRecord record;
  for (const char* law : {"smooth", "reference"}) {
    SceneInput input;
    input.mesh = options.mesh;
    input.fabric.path = options.fabric;
    input.law = law;
    LoadedScene scene = LoadScene(input);
    cloths.push_back({law, std::move(scene.model), std::move(scene.fabric.material.field)});
  }
  Study study = MakeGradientStudy(std::move(cloths), options.gradients);
  study.files = record.files();
  study.settings["material"] = NameInKey(options.fabric);
  study.settings["mesh"] = NameInKey(options.mesh);
  return RunStudyProgram(study, options.study, control);
}

}  // namespace

int GradientsMain(int argc, char** argv) {
  return ToolMain(argc, argv, GradientsTable, RunGradients);
}

}  // namespace drape
