// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/stability/stability_report.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/text_format.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

std::vector<int> CountOutcomes(const std::vector<int>& outcomes) {
  std::vector<int> counts(kStabilityOutcomes);
  for (const int outcome : outcomes)
    if (outcome != kNoRun) ++counts[outcome];
  return counts;
}

Json OutcomesJson(const std::vector<int>& counts) {
  Json json = Json::object();
  for (int i = 0; i < kStabilityOutcomes; ++i)
    json[ToString(static_cast<StabilityOutcome>(i))] = counts[i];
  return json;
}

std::vector<int> CountsOfAll(const StabilityAtlas& atlas) {
  std::vector<int> counts(kStabilityOutcomes);
  for (const auto& [inputs, run] : atlas.runs) ++counts[static_cast<int>(run.outcome)];
  return counts;
}

Json OptionalJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json MapJson(const StabilityAtlas& atlas, int index) {
  const StabilityMap& map = atlas.maps[index];
  Json json = {{"name", map.name},
               {"method", ToString(map.base.method)},
               {"law", map.base.law},
               {"scenario", ToString(map.base.scenario)},
               {"across", {{"axis", map.axis[0]->name}, {"values", map.values[0]}}},
               {"up", {{"axis", map.axis[1]->name}, {"values", map.values[1]}}}};
  Json rows = Json::array();
  const std::vector<int> outcomes = atlas.ListOutcomes(map);
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (i % map.values[0].size() == 0) rows.push_back(Json::array());
    rows.back().push_back(outcomes[i] == kNoRun
                              ? Json()
                              : Json(ToString(static_cast<StabilityOutcome>(outcomes[i]))));
  }
  json["counts"] = OutcomesJson(CountOutcomes(outcomes));
  json["rows_up"] = rows;
  for (const StabilityAtlas::Limit& each : atlas.limits)
    if (each.map == index)
      json["explicit_limits"].push_back({{"value", each.value},
                                         {"theory_s", OptionalJson(each.limit.theory)},
                                         {"measured_s", OptionalJson(each.limit.measured)}});
  return json;
}

// Of the outcomes that `shown` has.
std::string CountLine(const std::string& name, const std::vector<int>& counts,
                      const std::vector<int>& shown) {
  std::string line = Format("%-44s", name.c_str());
  for (int i = 0; i < kStabilityOutcomes; ++i)
    if (shown[i] > 0) line += Format(" %14d", counts[i]);
  return line + "\n";
}

std::string Milliseconds(const std::optional<double>& seconds) {
  return seconds ? Format("%10.4f", 1e3 * *seconds) : Format("%10s", "-");
}

std::string LimitText(const StabilityAtlas& atlas) {
  if (atlas.limits.empty()) return "";
  std::string text =
      Format("\nlargest stable explicit step %15s %10s %10s  [ms]\n", "at", "theory", "measured");
  for (const StabilityAtlas::Limit& each : atlas.limits)
    text +=
        Format("%-34s %9.4g %s %s\n", atlas.maps[each.map].name.c_str(), each.value,
               Milliseconds(each.limit.theory).c_str(), Milliseconds(each.limit.measured).c_str());
  return text;
}

std::string DampingText(const StabilityAtlas& atlas) {
  if (atlas.damping.empty()) return "";
  std::string text = Format("\n%-10s %8s %6s %12s %10s %10s\n", "a step of", "h [s]", "mode",
                            "omega [1/s]", "theory", "measured");
  for (const StabilityAtlas::Damping& each : atlas.damping)
    text += Format("%-10s %8g %6d %12.5g %10.6f %10.6f\n", ToString(each.run.method), each.run.h,
                   each.mode + 1, each.damping.omega, each.damping.theory, each.damping.measured);
  return text;
}

}  // namespace

std::string StabilityTableText(const StabilityAtlas& atlas) {
  const std::vector<int> all = CountsOfAll(atlas);
  std::string text = Format("%-44s", "runs");
  for (int i = 0; i < kStabilityOutcomes; ++i)
    if (all[i] > 0) text += Format(" %14s", ToString(static_cast<StabilityOutcome>(i)));
  text += "\n";
  for (const StabilityMap& map : atlas.maps)
    text += CountLine(map.name, CountOutcomes(atlas.ListOutcomes(map)), all);
  text += CountLine(Format("all %zu", atlas.runs.size()), all, all);
  return text + LimitText(atlas) + DampingText(atlas) + atlas.note;
}

void WriteStabilityFindings(const std::string& path, const StabilityOptions& options,
                            const StabilityAtlas& atlas) {
  Json json = {{"outcome", atlas.cancelled ? "cancelled" : "done"},
               {"runs", atlas.runs.size()},
               {"counts", OutcomesJson(CountsOfAll(atlas))},
               {"mesh", options.mesh},
               {"material", options.material},
               {"start", options.start},
               {"seed", options.seed},
               {"drag", options.drag},
               {"duration_s", options.duration},
               {"max_steps", options.max_steps},
               {"max_newton_steps", options.max_newton_steps},
               {"max_explicit_steps", options.max_explicit_steps},
               {"max_seconds", options.max_seconds}};
  json["maps"] = Json::array();
  for (std::size_t m = 0; m < atlas.maps.size(); ++m)
    json["maps"].push_back(MapJson(atlas, static_cast<int>(m)));
  json["damping"] = Json::array();
  for (const StabilityAtlas::Damping& each : atlas.damping)
    json["damping"].push_back({{"method", ToString(each.run.method)},
                               {"h_s", each.run.h},
                               {"mode", each.mode + 1},
                               {"omega_1_s", each.damping.omega},
                               {"steps", each.damping.steps},
                               {"theory", each.damping.theory},
                               {"measured", each.damping.measured}});
  json["seconds"] = atlas.seconds;
  if (!atlas.note.empty()) json["note"] = atlas.note.substr(0, atlas.note.find('\n'));
  WriteWithProvenance(path, std::move(json));
}

}  // namespace drape
