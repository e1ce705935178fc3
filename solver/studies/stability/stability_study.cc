// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_study.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "solver/studies/stability/stability_theory.h"

namespace drape {
namespace {

using nlohmann::json;

enum class Kind { kRun, kLimit, kDamping };

struct Task {
  Kind kind;
  StabilityCase run;
  int mode = 0;  // of damping

  std::string Name() const {
    const std::string name = CaseName(run);
    if (kind == Kind::kRun) return name;
    return kind == Kind::kLimit ? "limit of " + name
                                : "damping of " + name + " mode=" + std::to_string(mode + 1);
  }
  json Input() const {
    json input = CaseJson(run);
    input["kind"] = kind == Kind::kRun ? "run" : kind == Kind::kLimit ? "limit" : "damping";
    if (kind == Kind::kDamping) input["mode"] = mode + 1;
    return input;
  }
};

// Which axis of an explicit map is h; −1: neither.
int AxisOfH(const StabilityMap& map) {
  if (map.base.method != StabilityMethod::kExplicit) return -1;
  for (const int k : {0, 1})
    if (map.axis[k]->name == std::string("time_step")) return k;
  return -1;
}

// The cases of an explicit map whose largest time step is measured, by the values of the other
// axis.
std::vector<StabilityCase> LimitCases(const StabilityMap& map) {
  std::vector<StabilityCase> cases;
  const int h = AxisOfH(map);
  if (h < 0) return cases;
  for (const double value : map.values[1 - h]) {
    cases.push_back(map.base);
    map.axis[1 - h]->Set(cases.back(), value);
  }
  return cases;
}

std::vector<Task> ListTasks(const std::vector<StabilityMap>& maps,
                            const std::vector<double>& damping_h) {
  std::vector<Task> tasks;
  std::set<std::string> seen;
  const auto add = [&](const Task& task) {
    if (seen.insert(task.Name()).second) tasks.push_back(task);
  };
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : map.Cases()) add({Kind::kRun, run});
  for (const StabilityMap& map : maps)
    for (const StabilityCase& run : LimitCases(map)) add({Kind::kLimit, run});
  if (std::none_of(maps.begin(), maps.end(), [](const StabilityMap& map) {
        return map.base.scenario == StabilityScenario::kDrape;
      }))
    return tasks;
  for (const StabilityMethod method : {StabilityMethod::kStep, StabilityMethod::kImplicit})
    for (const int mode : {0, 9})
      for (const double h : damping_h) add({Kind::kDamping, {.method = method, .h = h}, mode});
  return tasks;
}

json OptionalJson(const std::optional<double>& value) { return value ? json(*value) : json(); }

json RunJson(const StabilityRun& run) {
  return {{"outcome", ToString(run.outcome)},
          {"steps", run.steps},
          {"seconds", run.seconds},
          {"residual", OptionalJson(run.residual)},
          {"speed_m_s", OptionalJson(run.speed)},
          {"distance_m", OptionalJson(run.distance)}};
}

json LimitJson(const ExplicitLimit& limit) {
  return {{"theory_s", OptionalJson(limit.theory)}, {"measured_s", OptionalJson(limit.measured)}};
}

json DampingJson(const std::optional<StepDamping>& damping) {
  if (!damping) return {{"omega_1_s", nullptr}};
  return {{"omega_1_s", damping->omega},
          {"steps", damping->steps},
          {"theory", damping->theory},
          {"measured", damping->measured}};
}

std::optional<json> RunTask(StabilityRunner& runner, const Task& task,
                            const std::atomic<bool>& cancel) {
  if (task.kind == Kind::kLimit) return LimitJson(MeasureLimit(runner, task.run));
  if (task.kind == Kind::kDamping) return DampingJson(MeasureDamping(runner, task.run, task.mode));
  const std::optional<StabilityRun> run = runner.Run(task.run, cancel);
  return run ? std::optional(RunJson(*run)) : std::nullopt;
}

json SettingsJson(const StabilitySetting& setting) {
  return {{"seed", setting.seed},
          {"duration_s", setting.duration},
          {"max_steps", setting.max_steps},
          {"max_newton_steps", setting.max_newton_steps},
          {"max_explicit_steps", setting.max_explicit_steps},
          {"max_seconds", setting.max_seconds},
          {"drag", setting.drag}};
}

nlohmann::ordered_json AxisJson(const StabilityMap& map, int k) {
  return {{"axis", map.axis[k]->name}, {"label", map.axis[k]->label}, {"values", map.values[k]}};
}

}  // namespace

Study MakeStabilityStudy(StabilityRunner& runner, const std::vector<StabilityMap>& maps,
                         const std::vector<double>& damping_h) {
  for (const StabilityMap& map : maps) {
    runner.MakeScene(map.At(0, 0));
    runner.MakeScene(map.Cases().back());
  }
  const auto tasks = std::make_shared<std::vector<Task>>(ListTasks(maps, damping_h));
  Study study{.name = "stability", .settings = SettingsJson(runner.setting())};
  for (const Task& task : *tasks) study.cells.push_back({task.Name(), task.Input()});
  study.run = [&runner, tasks](std::size_t cell, const RunControl& control) {
    return RunTask(runner, (*tasks)[cell], *control.cancel);
  };
  return study;
}

nlohmann::ordered_json MapsJson(const std::vector<StabilityMap>& maps) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const StabilityMap& map : maps) {
    nlohmann::ordered_json json = {{"name", map.name},
                                   {"base", CaseJson(map.base)},
                                   {"across", AxisJson(map, 0)},
                                   {"up", AxisJson(map, 1)},
                                   {"runs", nlohmann::ordered_json::array()}};
    for (const StabilityCase& run : map.Cases()) json["runs"].push_back(CaseName(run));
    for (const StabilityCase& run : LimitCases(map))
      json["limits"].push_back(Task{Kind::kLimit, run}.Name());
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace drape
