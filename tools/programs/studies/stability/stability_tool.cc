// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/stability/stability_tool.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "tools/cli/output_folder.h"
#include "tools/inputs/common_options.h"
#include "tools/programs/studies/stability/stability_report.h"

namespace drape {
namespace {

// What all rows of runs.csv share.
std::string SharedText(const StabilityOptions& o) {
  std::string text = "mesh=" + o.mesh + " material=" + o.material + " start=" + o.start +
                     " seed=" + std::to_string(o.seed) +
                     " most_steps=" + std::to_string(o.most_steps) +
                     " most_newton_steps=" + std::to_string(o.most_newton_steps) +
                     " most_explicit_steps=" + std::to_string(o.most_explicit_steps);
  AppendNumber(text += " most_seconds=", o.most_seconds);
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
          .most_steps = options.most_steps,
          .most_newton_steps = options.most_newton_steps,
          .most_explicit_steps = options.most_explicit_steps,
          .most_seconds = options.most_seconds,
          .drag = options.drag};
}

// Throws what the scenes of a run would.
void TryCorners(const StabilityRunner& bench, const std::vector<StabilityMap>& maps) {
  for (const StabilityMap& map : maps) {
    bench.MakeScene(map.At(0, 0));
    bench.MakeScene(map.Cases().back());
  }
}

int CountThreads(const StabilityOptions& options) {
  return options.threads > 0 ? options.threads
                             : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Which axis of an explicit map is h; −1: neither.
int AxisOfH(const StabilityMap& map) {
  if (map.base.method != StabilityMethod::kExplicit) return -1;
  for (const int k : {0, 1})
    if (map.axis[k]->name == std::string("time_step")) return k;
  return -1;
}

void FindLimits(const StabilityRunner& bench, int threads, StabilityAtlas& atlas) {
  std::vector<StabilityCase> runs;
  for (int m = 0; m < static_cast<int>(atlas.maps.size()); ++m) {
    const StabilityMap& map = atlas.maps[m];
    const int h = AxisOfH(map);
    if (h < 0) continue;
    for (const double value : map.values[1 - h]) {
      runs.push_back(map.base);
      map.axis[1 - h]->Set(runs.back(), value);
      atlas.limits.push_back({m, value, {}});
    }
  }
  const std::vector<ExplicitLimit> limits = MeasureLimits(bench, runs, threads);
  for (std::size_t i = 0; i < limits.size(); ++i) atlas.limits[i].limit = limits[i];
}

void FindDamping(StabilityRunner& bench, const std::vector<double>& steps, StabilityAtlas& atlas) {
  for (const StabilityMethod method : {StabilityMethod::kStep, StabilityMethod::kImplicit})
    for (const int mode : {0, 9})
      for (const double h : steps) {
        StabilityCase run;
        run.method = method;
        run.h = h;
        if (const std::optional<StepDamping> damping = MeasureDamping(bench, run, mode))
          atlas.damping.push_back({run, mode, *damping});
      }
}

std::vector<Option> SettingOptions(StabilityOptions& o) {
  return {
      MeshOption("mesh", &o.mesh, "disc:N, or a mesh file"),
      {.key = "material",
       .value = &o.material,
       .doc = "fabric; its density is each run's own",
       .is_path = true,
       .required = true},
      {.key = "start",
       .value = &o.start,
       .doc = "start shape, which decides the branch",
       .is_path = true,
       .required = true},
      {.key = "seed", .value = &o.seed, .doc = "of tangled starts", .least = 0, .most = 1000000000},
      {.key = "drag",
       .value = &o.drag,
       .doc = "of the air in the explicit method",
       .unit = "1/s",
       .least = 0,
       .most = 1000},
      {.key = "duration",
       .value = &o.duration,
       .doc = "simulated time of a run; at least 40 steps",
       .unit = "s",
       .least = 0,
       .most = 1000,
       .above_least = true},
      {.key = "max_steps",
       .value = &o.most_steps,
       .doc = "budget of an implicit run",
       .least = 10,
       .most = 10000000},
      {.key = "max_newton_steps",
       .value = &o.most_newton_steps,
       .doc = "budget of a static run",
       .least = 10,
       .most = 10000000},
      {.key = "max_explicit_steps",
       .value = &o.most_explicit_steps,
       .doc = "budget of an explicit run",
       .least = 10,
       .most = 100000000},
      {.key = "max_seconds",
       .value = &o.most_seconds,
       .doc = "budget of a run",
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
       .doc = "'methods axis=values axis=values', as 'step+implicit h=1e-3:0.5:9 "
              "stiffness=0.1/1/10'; one value sets, law=reference too",
       .required = true},
      {.key = "filter", .value = &o.only, .doc = "the maps with this text in their name"},
      {.key = "damping_time_step",
       .value = &o.damping_h,
       .doc = "time steps at which the damping of vibrations is measured",
       .unit = "s",
       .least = 0,
       .most = 10,
       .above_least = true},
      {.key = "threads",
       .value = &o.threads,
       .doc = "runs at a time; 0: all cores",
       .least = 0,
       .most = 1024},
      {.key = "resume", .value = &o.resume, .doc = "keep the runs that runs.csv in --out has"},
      OutOption(o.out),
  };
}

}  // namespace

std::vector<int> StabilityAtlas::ClassifyRuns(const StabilityMap& map) const {
  std::vector<int> kinds;
  for (const StabilityCase& run : map.Cases()) {
    const auto found = runs.find(StabilityInputs(run));
    kinds.push_back(found == runs.end() ? kNoRun : static_cast<int>(found->second.kind));
  }
  return kinds;
}

StabilityLine StabilityAtlas::MakeLine(int map) const {
  StabilityLine line{.title = "2/ω, theory", .x = {}, .y = {}};
  const int h = AxisOfH(maps[map]);
  for (const Limit& each : limits) {
    if (each.map != map || !each.limit.theory) continue;
    (h == 0 ? line.x : line.y).push_back(*each.limit.theory);
    (h == 0 ? line.y : line.x).push_back(each.value);
  }
  return line;
}

OptionTable StabilityTable(StabilityOptions& options) {
  std::string axes;
  for (const StabilityAxis& axis : StabilityAxes())
    axes += std::string("  ") + axis.name + ": " + axis.label + "\n";
  std::string methods;
  for (int i = 0; i < kStabilityMethods; ++i)
    methods += std::string(" ") + ToString(static_cast<StabilityMethod>(i));
  std::vector<Option> all = SettingOptions(options);
  for (const Option& option : SurveyOptions(options)) all.push_back(option);
  return {.tool = "drape_stability",
          .summary = "where methods of solving a drape fail: a run a cell of maps over two axes",
          .example =
              "drape_stability --config=configs/studies/stability_quick.json --out=out/stability",
          .notes = "methods:" + methods + "\naxes:\n" + axes +
                   "files: runs.csv, to which each finished run is appended, findings.json and a "
                   "PNG a map\nCtrl-C keeps the finished runs; --resume goes on\n",
          .options = std::move(all)};
}

StabilityAtlas MakeStabilityAtlas(const StabilityOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  StabilityAtlas atlas;
  atlas.maps = SelectMaps(options);
  StabilityRunner bench(MakeSetting(options));
  TryCorners(bench, atlas.maps);
  const OutputFolder out(options.out);
  const std::string path = options.out + "/runs.csv", shared = SharedText(options);
  if (options.resume && std::filesystem::exists(path)) atlas.runs = ReadStabilityRuns(path, shared);
  WriteStabilityRuns(path, shared, atlas.runs);
  const int threads = CountThreads(options);
  atlas.cancelled = !SurveyStability(bench, atlas.maps, threads, path, control, atlas.runs);
  if (!atlas.cancelled) {
    FindLimits(bench, threads, atlas);
    FindDamping(bench, options.damping_h, atlas);
  }
  atlas.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (int m = 0; m < static_cast<int>(atlas.maps.size()); ++m)
    RenderStabilityMap(out.Staged(atlas.maps[m].name + ".png"), atlas.maps[m],
                       atlas.ClassifyRuns(atlas.maps[m]), atlas.MakeLine(m));
  WriteStabilityFindings(out.Staged("findings.json"), options, atlas);
  out.Publish();
  return atlas;
}

}  // namespace drape
