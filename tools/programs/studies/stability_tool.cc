// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "solver/studies/stability/stability_study.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/study_program.h"

namespace drape {
namespace {

// The options of drape_stability.
struct StabilityOptions {
  std::string mesh = "disc:120";      // ParseMeshSpec
  std::string fabric = kBuiltInName;  // ReadMaterial; each run sets the density
  std::string start;                  // ReadStartShape
  StabilitySetting setting;           // its mesh, material and start are read from these
  std::vector<std::string> maps;      // ParseStabilityMaps
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};
  StudyOptions study = {.threads = 0};  // 0: all cores
};

std::vector<Option> SettingOptions(StabilityOptions& o) {
  return {
      MeshOption("mesh", &o.mesh, "disc:N, or a mesh file"),
      FabricOption(&o.fabric),
      {.key = "start",
       .value = &o.start,
       .doc = "start shape, which selects the branch",
       .is_path = true,
       .required = true},
      NumberOption("seed", &o.setting.seed, 0, 1000000000,
                   "random seed of the run, which only tangled starts use"),
      NumberOption("drag", &o.setting.drag, 0, 1000, "air drag of the explicit method", "1/s"),
      PositiveOption("duration", &o.setting.duration, 1000,
                     "simulated time of a run, at least 40 steps", "s"),
  };
}

std::vector<Option> LimitOptions(StabilityOptions& o) {
  return {
      NumberOption("max_steps", &o.setting.max_steps, 10, 10000000,
                   "largest number of steps of an implicit run"),
      NumberOption("max_newton_steps", &o.setting.max_newton_steps, 10, 10000000,
                   "largest number of Newton steps of a static run"),
      NumberOption("max_explicit_steps", &o.setting.max_explicit_steps, 10, 100000000,
                   "largest number of steps of an explicit run"),
      PositiveOption("max_seconds", &o.setting.max_seconds, 1e6, "largest computing time of a run",
                     "s"),
  };
}

std::vector<Option> SurveyOptions(StabilityOptions& o) {
  return {
      {.key = "maps",
       .value = &o.maps,
       .doc =
           "maps as 'methods axis=values axis=values', such as 'step+implicit time_step=1e-3:0.5:9 "
           "stiffness=0.1/1/10'; an axis with one value is constant, as is law=reference",
       .required = true},
      PositiveOption("damping_time_step", &o.damping_h, 10,
                     "time steps at which the damping of vibrations is measured", "s"),
      ThreadsOption(o.study.threads),
  };
}

OptionTable StabilityTable(StabilityOptions& options) {
  std::string axes, methods;
  for (const StabilityAxis& axis : StabilityAxes())
    axes += std::string("  ") + axis.name + ": " + axis.label + "\n";
  for (const auto& [method, name] : EnumNames(StabilityMethod{}))
    methods += std::string(" ") + name;
  return {
      .tool = "drape_stability",
      .summary = "maps the outcome of solvers of a drape over two parameters",
      .example =
          "drape_stability --config=configs/studies/stability_quick.json --out=out/stability",
      .notes = "methods:" + methods + "\naxes:\n" + axes +
               "files: cells/ (each finished run), stability.json, runs.csv, overview.svg (share "
               "of runs that succeed by method and hardship) and one picture per map\n"
               "The same command continues a study that was stopped.\n",
      .options = Concatenate(
          Grouped("maps and results",
                  Concatenate(SurveyOptions(options), StudyOptionList(options.study))),
          Grouped("simulation", Concatenate(SettingOptions(options), LimitOptions(options))))};
}

ToolOutcome RunStability(const StabilityOptions& given, const RunControl& control) {
  const ReadRecord record;
  StabilityOptions options = given;
  options.study.threads = CountThreads(options.study.threads);
  std::vector<StabilityMap> maps;
  for (const std::string& line : options.maps)
    for (StabilityMap& map : ParseStabilityMaps(line, "option 'maps'"))
      maps.push_back(std::move(map));
  options.setting.mesh = ParseMeshSpec(options.mesh);
  options.setting.material = ReadMaterial(options.fabric).field;
  options.setting.start = ReadStartShape(options.start);
  StabilityRunner runner(options.setting);
  Study study = MakeStabilityStudy(runner, maps, options.damping_h);
  study.files = record.files();
  study.settings["mesh"] = NameInKey(options.mesh);
  study.settings["material"] = NameInKey(options.fabric);
  const auto summarise = [&](const StudyResult& result) {
    nlohmann::ordered_json json = SummariseCells(study, result);
    json["settings"].update(nlohmann::ordered_json{{"mesh", NameWithoutFolder(options.mesh)},
                                                   {"material", NameWithoutFolder(options.fabric)},
                                                   {"start", NameWithoutFolder(options.start)}});
    for (const StabilityAxis& axis : StabilityAxes()) json["axes"][axis.name] = axis.label;
    json["usual"] = CaseJson({});
    json["maps"] = MapsJson(maps);
    return json;
  };
  return RunStudyProgram(study, options.study, control, summarise);
}

}  // namespace

int StabilityMain(int argc, char** argv) {
  return ToolMain(argc, argv, StabilityTable, RunStability);
}

}  // namespace drape
