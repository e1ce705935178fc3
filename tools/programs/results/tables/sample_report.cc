// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/sample_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "losses/metrics/sample_statistics.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;
using Pictures = std::vector<const MeasuredSample*>;

constexpr double kPercent = 100;

// The pictures by the texts of a column, in the order of their first ones.
std::vector<std::pair<std::string, Pictures>> SplitBy(const Pictures& pictures,
                                                      const std::string& column) {
  std::vector<std::pair<std::string, Pictures>> parts;
  for (const MeasuredSample* each : pictures) {
    const std::string text = each->row.of(column);
    auto part = std::ranges::find(parts, text, [](const auto& known) { return known.first; });
    if (part == parts.end()) part = parts.insert(part, {text, {}});
    part->second.push_back(each);
  }
  return parts;
}

// The error of one photograph, which all pictures of a group may share [%].
double SharedError(const Pictures& pictures) {
  double squares = 0.0;
  for (const MeasuredSample* each : pictures) squares += std::pow(each->coefficient_sd, 2);
  return kPercent * std::sqrt(squares / static_cast<double>(pictures.size()));
}

SampleMean MeanOfFaces(const Pictures& pictures) {
  std::vector<std::vector<double>> faces;
  for (const auto& [face, seen] : SplitBy(pictures, "face")) {
    faces.emplace_back();
    for (const MeasuredSample* each : seen) faces.back().push_back(kPercent * each->coefficient);
  }
  return MeanOfStrata(faces, SharedError(pictures));
}

// The mean of the parts of a column that show all faces; where none does, of the faces' means.
SampleMean MeanOfParts(const Pictures& pictures, const std::string& column,
                       const std::function<SampleMean(const Pictures&)>& mean) {
  const std::size_t faces = SplitBy(pictures, "face").size();
  std::map<std::string, std::vector<double>> by_face;
  std::vector<double> whole;
  for (const auto& [name, part] : SplitBy(pictures, column)) {
    const auto found = SplitBy(part, "face");
    if (found.size() == faces) whole.push_back(mean(part).mean);
    for (const auto& [face, seen] : found) by_face[face].push_back(mean(seen).mean);
  }
  std::vector<std::vector<double>> strata;
  if (!whole.empty()) strata.push_back(whole);
  for (const auto& [face, values] : by_face)
    if (whole.empty()) strata.push_back(values);
  return MeanOfStrata(strata, SharedError(pictures));
}

SampleMean MeanOfSpecimens(const Pictures& pictures) {
  return MeanOfParts(pictures, "specimen", MeanOfFaces);
}

bool NamesSpecimens(const Pictures& pictures) {
  return std::ranges::none_of(
      pictures, [](const MeasuredSample* each) { return each->row.of("specimen").empty(); });
}

std::vector<int> MostFrequentNodes(const Pictures& pictures) {
  std::map<int, int> counts;
  int most = 0;
  for (const MeasuredSample* each : pictures) most = std::max(most, ++counts[each->nodes]);
  std::vector<int> found;
  for (const auto& [nodes, count] : counts)
    if (count == most) found.push_back(nodes);
  return found;
}

Json Known(bool known, double value) { return known ? Json(value) : Json(); }

// The names of a group, "" for all, and its mean. Pictures without specimens have no known
// interval.
struct Group {
  std::string fabric, sample, specimen, face;
  Pictures pictures;
  const char* of = "pictures";
  SampleMean dc;
  std::optional<double> half_width;

  Group(std::string in_fabric, std::string in_sample, std::string of_specimen, std::string on_face,
        Pictures seen)
      : fabric(std::move(in_fabric)),
        sample(std::move(in_sample)),
        specimen(std::move(of_specimen)),
        face(std::move(on_face)),
        pictures(std::move(seen)) {
    const bool has_specimens = NamesSpecimens(pictures);
    if (!specimen.empty() || !has_specimens) {
      dc = MeanOfFaces(pictures);
    } else if (sample.empty() && SplitBy(pictures, "sample").size() > 1) {
      dc = MeanOfParts(pictures, "sample", MeanOfSpecimens);
      of = "samples";
    } else {
      dc = MeanOfSpecimens(pictures);
      of = "specimens";
    }
    if (has_specimens) half_width = dc.HalfWidth();
  }

  Json ToJson() const {
    const double half = half_width.value_or(0.0);
    return {{"fabric", fabric},
            {"sample", sample},
            {"specimen", specimen},
            {"face", face},
            {"pictures", pictures.size()},
            {"dc_percent", dc.mean},
            {"dc_sd_percent", Known(dc.spread_is_known(), dc.deviation)},
            {"n", dc.count},
            {"of", of},
            {"dc_low_percent", Known(half_width.has_value(), dc.mean - half)},
            {"dc_high_percent", Known(half_width.has_value(), dc.mean + half)},
            {"nodes", MostFrequentNodes(pictures)}};
  }
};

// Each face, where there are two, and then all together.
void AppendGroups(const std::string& fabric, const std::string& sample, const std::string& specimen,
                  const Pictures& pictures, Json* groups) {
  const auto faces = SplitBy(pictures, "face");
  for (const auto& [face, seen] : faces)
    groups->push_back(Group(fabric, sample, specimen, face, seen).ToJson());
  if (faces.size() > 1) groups->push_back(Group(fabric, sample, specimen, "", pictures).ToJson());
}

Json GroupsJson(const Pictures& measured) {
  Json groups = Json::array();
  for (const auto& [fabric, of_fabric] : SplitBy(measured, "fabric")) {
    AppendGroups(fabric, "", "", of_fabric, &groups);
    const auto samples = SplitBy(of_fabric, "sample");
    for (const auto& [sample, of_sample] : samples) {
      if (samples.size() > 1) AppendGroups(fabric, sample, "", of_sample, &groups);
      for (const auto& [specimen, seen] : SplitBy(of_sample, "specimen"))
        if (!specimen.empty()) AppendGroups(fabric, sample, specimen, seen, &groups);
    }
  }
  return groups;
}

// a: the group of the higher coefficient.
Json DifferenceJson(const Group& a, const Group& b) {
  const SampleMean found = WelchDifference(a.dc, b.dc);
  const bool known = a.half_width && b.half_width;
  const double half = known ? found.HalfWidth().value() : 0.0;
  const std::string interval =
      Format("%.1f points (90 %%: %.1f … %.1f)", found.mean, found.mean - half, found.mean + half);
  std::string text = "the drape coefficient of " + a.fabric;
  if (!known)
    text += Format(" is %.1f points higher than that of ", found.mean) + b.fabric +
            "; the interval is unknown: it takes two specimens of each, named in the table";
  else if (found.mean > half)
    text += " is higher than that of " + b.fabric + " by " + interval;
  else
    text += " is not distinguished from that of " + b.fabric + ": the difference is " + interval;
  return {{"a", a.fabric},
          {"b", b.fabric},
          {"dc_points", found.mean},
          {"low", Known(known, found.mean - half)},
          {"high", Known(known, found.mean + half)},
          {"text", text}};
}

// Differences of all pairs of fabrics whose specimens are of one size.
Json DifferencesJson(const Pictures& measured) {
  std::vector<Group> fabrics;
  for (const auto& [fabric, seen] : SplitBy(measured, "fabric"))
    fabrics.emplace_back(fabric, "", "", "", seen);
  std::ranges::stable_sort(fabrics, std::greater(), [](const Group& each) { return each.dc.mean; });
  Json differences = Json::array();
  for (std::size_t a = 0; a < fabrics.size(); ++a)
    for (std::size_t b = a + 1; b < fabrics.size(); ++b)
      if (fabrics[a].pictures[0]->row.diameter == fabrics[b].pictures[0]->row.diameter)
        differences.push_back(DifferenceJson(fabrics[a], fabrics[b]));
  return differences;
}

// A value as a field of a table; what is unknown is `unknown`.
std::string FieldText(const Json& value, const char* number, const std::string& unknown) {
  if (value.is_array()) {
    std::string text;
    for (const Json& each : value) text += (text.empty() ? "" : " or ") + each.dump();
    return text;
  }
  if (value.is_string()) return value;
  return value.is_null() ? unknown : Format(number, value.get<double>());
}

}  // namespace

Json SamplesJson(const std::vector<MeasuredSample>& pictures) {
  Json json = {{"pictures", Json::array()}, {"notes", Json::array()}};
  Pictures measured;
  for (const MeasuredSample& each : pictures) {
    const bool is_measured = each.error.empty();
    if (is_measured) measured.push_back(&each);
    Json picture = each.row.cells;
    picture["dc_percent"] = Known(is_measured, kPercent * each.coefficient);
    picture["dc_sd_percent"] = Known(is_measured, kPercent * each.coefficient_sd);
    picture["nodes"] = Known(is_measured, each.nodes);
    picture["notes"] = each.notes;
    picture["error"] = each.error;
    json["pictures"].push_back(std::move(picture));
    if (!is_measured) json["notes"].push_back("not measured: " + each.row.file + ": " + each.error);
  }
  if (!NamesSpecimens(measured))
    json["notes"].push_back(
        "which pictures show one specimen is unknown, and so are intervals: a table of samples "
        "tells it in the column 'specimen'");
  json["groups"] = GroupsJson(measured);
  json["differences"] = DifferencesJson(measured);
  return json;
}

std::string SamplesText(const Json& samples) {
  constexpr const char* kRow = "%-14s %-8s %-8s %-6s %8s %8s  %-13s %-14s %s\n";
  std::string text =
      Format(kRow, "fabric", "sample", "specimen", "face", "DC [%]", "sd", "n", "90 %", "nodes");
  for (const Json& group : samples.at("groups")) {
    const auto field = [&](const char* key) { return FieldText(group.at(key), "%.1f", "unknown"); };
    const auto name = [&](const char* key) { return field(key).empty() ? "all" : field(key); };
    std::string of = group.at("of");
    const int count = group.at("n");
    if (count == 1) of.pop_back();
    const std::string low = field("dc_low_percent");
    text += Format(kRow, name("fabric").c_str(), name("sample").c_str(), name("specimen").c_str(),
                   name("face").c_str(), field("dc_percent").c_str(),
                   field("dc_sd_percent").c_str(), (std::to_string(count) + " " + of).c_str(),
                   (low == "unknown" ? low : low + " … " + field("dc_high_percent")).c_str(),
                   field("nodes").c_str());
  }
  for (const Json& each : samples.at("differences"))
    text += each.at("text").get<std::string>() + "\n";
  for (const Json& note : samples.at("notes")) text += "note: " + note.get<std::string>() + "\n";
  return text;
}

std::string CsvOfObjects(const Json& objects) {
  std::string text, line;
  for (const auto& [key, value] : objects.front().items()) line += "," + CsvField(key);
  for (const Json& object : objects) {
    text += line.substr(1) + "\n";
    line.clear();
    for (const auto& [key, value] : object.items())
      line += "," + CsvField(FieldText(value, "%.6g", ""));
  }
  return text + line.substr(1) + "\n";
}

}  // namespace drape
