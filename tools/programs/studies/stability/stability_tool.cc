// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/stability/stability_tool.h"

#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/stability/stability_picture.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/studies/stability/stability_report.h"

namespace drape {
namespace {

// What all rows of runs.csv share.
std::string SharedText(const StabilityOptions& o) {
  std::string text = "mesh=" + o.mesh + " material=" + o.material + " start=" + o.start +
                     " seed=" + std::to_string(o.seed) +
                     " max_steps=" + std::to_string(o.max_steps) +
                     " max_newton_steps=" + std::to_string(o.max_newton_steps) +
                     " max_explicit_steps=" + std::to_string(o.max_explicit_steps);
  AppendNumber(text += " max_seconds=", o.max_seconds);
  AppendNumber(text += " duration=", o.duration);
  AppendNumber(text += " drag=", o.drag);
  return text;
}

std::vector<StabilityMap> SelectMaps(const StabilityOptions& options) {
  std::vector<StabilityMap> maps;
  for (const std::string& line : options.maps)
    for (StabilityMap& map : ParseStabilityMaps(line, "option 'maps'"))
      if (map.name.find(options.only) != std::string::npos) maps.push_back(std::move(map));
  if (maps.empty())
    throw InputError("option 'filter'",
                     "found '" + options.only + "', which no map has in its name");
  return maps;
}

StabilitySetting MakeSetting(const StabilityOptions& options) {
  return {.mesh = ParseMeshSpec(options.mesh),
          .material = ReadMaterial(options.material).field,
          .start = ReadStartShape(options.start),
          .seed = options.seed,
          .duration = options.duration,
          .max_steps = options.max_steps,
          .max_newton_steps = options.max_newton_steps,
          .max_explicit_steps = options.max_explicit_steps,
          .max_seconds = options.max_seconds,
          .drag = options.drag};
}

std::vector<Option> SettingOptions(StabilityOptions& o) {
  return {
      MeshOption("mesh", &o.mesh, "disc:N, or a mesh file"),
      {.key = "material",
       .value = &o.material,
       .doc = "material file; each run sets the density",
       .is_path = true,
       .required = true},
      {.key = "start",
       .value = &o.start,
       .doc = "start shape, which selects the branch",
       .is_path = true,
       .required = true},
      {.key = "seed",
       .value = &o.seed,
       .doc = "random seed of the run, which only tangled starts use",
       .least = 0,
       .most = 1000000000},
      {.key = "drag",
       .value = &o.drag,
       .doc = "air drag of the explicit method",
       .unit = "1/s",
       .least = 0,
       .most = 1000},
      {.key = "duration",
       .value = &o.duration,
       .doc = "simulated time of a run, at least 40 steps",
       .unit = "s",
       .least = 0,
       .most = 1000,
       .above_least = true},
      BaseOption(o.base),
  };
}

std::vector<Option> LimitOptions(StabilityOptions& o) {
  return {
      {.key = "max_steps",
       .value = &o.max_steps,
       .doc = "largest number of steps of an implicit run",
       .least = 10,
       .most = 10000000},
      {.key = "max_newton_steps",
       .value = &o.max_newton_steps,
       .doc = "largest number of Newton steps of a static run",
       .least = 10,
       .most = 10000000},
      {.key = "max_explicit_steps",
       .value = &o.max_explicit_steps,
       .doc = "largest number of steps of an explicit run",
       .least = 10,
       .most = 100000000},
      {.key = "max_seconds",
       .value = &o.max_seconds,
       .doc = "largest computing time of a run",
       .unit = "s",
       .least = 0,
       .most = 1e6,
       .above_least = true},
  };
}

std::vector<Option> SurveyOptions(StabilityOptions& o) {
  return {
      {.key = "maps",
       .value = &o.maps,
       .doc =
           "maps as 'methods axis=values axis=values', such as 'step+implicit time_step=1e-3:0.5:9 "
           "stiffness=0.1/1/10'; an axis with one value is constant, as are law=reference and "
           "scenario=plate",
       .required = true},
      {.key = "filter",
       .value = &o.only,
       .doc = "text in the names of the maps to compute; none: all maps"},
      {.key = "damping_time_step",
       .value = &o.damping_h,
       .doc = "time steps at which the damping of vibrations is measured",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      ThreadsOption(o.threads),
      {.key = "resume",
       .value = &o.resume,
       .doc = "keep the finished runs of runs.csv in --out",
       .repeated = false},
      OutOption(o.out),
  };
}

StabilityAtlasOptions MakeAtlasOptions(const StabilityOptions& options) {
  return {.runs = options.out + "/runs.csv",
          .shared = SharedText(options),
          .resume = options.resume,
          .cells = options.out + "/cells",
          .share = options.cells.ParseShare(),
          .damping_h = options.damping_h,
          .threads = CountThreads(options.threads)};
}

void RenderMaps(const OutputFolder& out, const StabilityAtlas& atlas) {
  RenderStabilityOverview(out.Staged("overview.png"), atlas);
  for (int m = 0; m < static_cast<int>(atlas.maps.size()); ++m)
    RenderStabilityMap(out.Staged(atlas.maps[m].name + ".png"), atlas.maps[m],
                       atlas.ListOutcomes(atlas.maps[m]), atlas.MakeLine(m));
}

}  // namespace

OptionTable StabilityTable(StabilityOptions& options) {
  std::string axes;
  for (const StabilityAxis& axis : StabilityAxes())
    axes += std::string("  ") + axis.name + ": " + axis.label + "\n";
  std::string methods;
  for (int i = 0; i < kStabilityMethods; ++i)
    methods += std::string(" ") + ToString(static_cast<StabilityMethod>(i));
  std::string scenarios;
  for (int i = 0; i < kStabilityScenarios; ++i)
    scenarios += std::string(" ") + ToString(static_cast<StabilityScenario>(i));
  return {
      .tool = "drape_stability",
      .summary = "maps the outcome of solvers of a drape, or of contact, over two parameters",
      .example =
          "drape_stability --config=configs/studies/stability_quick.json --out=out/stability",
      .notes = "methods:" + methods + "\nscenarios:" + scenarios + "\naxes:\n" + axes +
               "files: runs.csv, to which each finished run is appended, findings.json, "
               "overview.png (share of runs that succeed by method and hardship) and one PNG per "
               "map\nCtrl-C keeps the finished runs; --resume continues with the others.\n",
      .options = Concatenate(
          Grouped("maps and results",
                  Concatenate(SurveyOptions(options), CellOptions(options.cells))),
          Grouped("simulation", Concatenate(SettingOptions(options), LimitOptions(options))))};
}

std::string ListStabilityText(const StabilityOptions& options) {
  return ListText(ListStabilityCells(SelectMaps(options)), options.cells.ParseShare());
}

std::string StabilityShareText(const StabilityOptions& options, const StabilityAtlas& atlas) {
  const std::optional<Share> share = options.cells.ParseShare();
  const std::size_t all = ListStabilityCells(atlas.maps).size();
  std::size_t mine = 0;
  for (std::size_t k = 0; k < all; ++k) mine += share->Has(k);
  return ShareText(options.cells.share, atlas.runs.size(), mine);
}

StabilityAtlas RunStability(const StabilityOptions& given, const RunControl& control) {
  StabilityOptions options = given;
  ApplyBase(options.base, {&options.material});
  StabilityRunner runner(MakeSetting(options));
  std::vector<StabilityMap> maps = SelectMaps(options);
  CheckScenes(runner, maps);
  const StabilityAtlasOptions atlas_options = MakeAtlasOptions(options);
  const bool is_share = atlas_options.share.has_value();
  const OutputFolder out(options.out, {"findings.json", "runs.csv"},
                         is_share ? OutputFolder::Use::kShared : OutputFolder::Use::kAlone);
  StabilityAtlas atlas = MakeStabilityAtlas(runner, std::move(maps), atlas_options, control);
  if (is_share) return atlas;
  atlas.note = TryPictures([&] { RenderMaps(out, atlas); });
  WriteStabilityFindings(out.Staged("findings.json"), options, atlas);
  out.Publish();
  return atlas;
}

namespace {

ToolOutcome Run(const StabilityOptions& options, const RunControl& control) {
  if (options.cells.list) return {.text = ListStabilityText(options)};
  const StabilityAtlas atlas = RunStability(options, control);
  if (!options.cells.share.empty())
    return {.text = StabilityShareText(options, atlas), .cancelled = atlas.cancelled};
  return {.text = StabilityTableText(atlas), .cancelled = atlas.cancelled};
}

}  // namespace

int StabilityMain(int argc, char** argv) { return ToolMain(argc, argv, StabilityTable, Run); }

}  // namespace drape
