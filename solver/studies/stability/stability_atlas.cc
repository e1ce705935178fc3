// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_atlas.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "physics/util/atomic_file.h"
#include "solver/studies/cells/cell_folder.h"
#include "solver/studies/stability/contact/contact_theory.h"

namespace drape {
namespace {

// Which axis of an explicit map is h; −1: neither.
int AxisOfH(const StabilityMap& map) {
  if (map.base.method != StabilityMethod::kExplicit) return -1;
  for (const int k : {0, 1})
    if (map.axis[k]->name == std::string("time_step")) return k;
  return -1;
}

void FindLimits(const StabilityRunner& runner, int threads, StabilityAtlas& atlas) {
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
  const std::vector<ExplicitLimit> limits = MeasureLimits(runner, runs, threads);
  for (std::size_t i = 0; i < limits.size(); ++i) atlas.limits[i].limit = limits[i];
}

void FindDamping(StabilityRunner& runner, const std::vector<double>& steps, StabilityAtlas& atlas) {
  for (const StabilityMethod method : {StabilityMethod::kStep, StabilityMethod::kImplicit})
    for (const int mode : {0, 9})
      for (const double h : steps) {
        StabilityCase run;
        run.method = method;
        run.h = h;
        if (const std::optional<StepDamping> damping = MeasureDamping(runner, run, mode))
          atlas.damping.push_back({run, mode, *damping});
      }
}

// Adds the finished runs of shares.
void TakeOver(const CellFolder& cells, const std::vector<StabilityCase>& cases,
              StabilityRuns& runs) {
  for (const StabilityCase& run : cases) {
    const std::string inputs = StabilityInputs(run);
    if (runs.contains(inputs)) continue;
    if (const std::optional<std::string> row = cells.Read(inputs))
      ParseStabilityRow(*row, cells.Path(inputs), runs);
  }
}

void RunShare(StabilityRunner& runner, const StabilityAtlasOptions& options, CellFolder& cells,
              const RunControl& control, StabilityAtlas& atlas) {
  const std::vector<StabilityCase> all = DistinctCases(atlas.maps);
  std::vector<StabilityCase> mine;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (options.share->Has(k)) mine.push_back(all[k]);
  TakeOver(cells, mine, atlas.runs);
  cells.Create();
  const auto keep = [&](const std::string& inputs, const StabilityRun& run) {
    cells.Write(inputs, StabilityRow(inputs, run));
  };
  atlas.cancelled = !SurveyStability(runner, mine, options.threads, keep, control, atlas.runs);
}

}  // namespace

std::vector<std::string> ListStabilityCells(const std::vector<StabilityMap>& maps) {
  std::vector<std::string> cells;
  for (const StabilityCase& run : DistinctCases(maps)) cells.push_back(StabilityInputs(run));
  return cells;
}

std::vector<int> StabilityAtlas::ListOutcomes(const StabilityMap& map) const {
  std::vector<int> outcomes;
  for (const StabilityCase& run : map.Cases()) {
    const auto found = runs.find(StabilityInputs(run));
    outcomes.push_back(found == runs.end() ? kNoRun : static_cast<int>(found->second.outcome));
  }
  return outcomes;
}

StabilityLine StabilityAtlas::MakeLine(int map) const {
  if (IsOfContact(maps[map].base.scenario)) return MakeContactLine(maps[map]);
  StabilityLine line{.title = "2/ω, theory", .x = {}, .y = {}};
  const int h = AxisOfH(maps[map]);
  for (const Limit& each : limits) {
    if (each.map != map || !each.limit.theory) continue;
    (h == 0 ? line.x : line.y).push_back(*each.limit.theory);
    (h == 0 ? line.y : line.x).push_back(each.value);
  }
  return line;
}

void CheckScenes(const StabilityRunner& runner, const std::vector<StabilityMap>& maps) {
  for (const StabilityMap& map : maps) {
    runner.Check(map.At(0, 0));
    runner.Check(map.Cases().back());
  }
}

StabilityAtlas MakeStabilityAtlas(StabilityRunner& runner, std::vector<StabilityMap> maps,
                                  const StabilityAtlasOptions& options, const RunControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  StabilityAtlas atlas;
  atlas.maps = std::move(maps);
  CellFolder cells(options.cells, options.shared);
  if (options.share) {
    RunShare(runner, options, cells, control, atlas);
    return atlas;
  }
  if (options.resume && std::filesystem::exists(options.runs))
    atlas.runs = ReadStabilityRuns(options.runs, options.shared);
  RemoveTemporaries(options.cells);
  TakeOver(cells, DistinctCases(atlas.maps), atlas.runs);
  WriteStabilityRuns(options.runs, options.shared, atlas.runs);
  atlas.cancelled =
      !SurveyStability(runner, atlas.maps, options.threads, options.runs, control, atlas.runs);
  if (!atlas.cancelled) {
    WriteStabilityRuns(options.runs, options.shared, atlas.runs);  // now in their order
    FindLimits(runner, options.threads, atlas);
    const auto is_drape = [](const StabilityMap& map) {
      return map.base.scenario == StabilityScenario::kDrape;
    };
    if (std::any_of(atlas.maps.begin(), atlas.maps.end(), is_drape))
      FindDamping(runner, options.damping_h, atlas);
  }
  atlas.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return atlas;
}

}  // namespace drape
