// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/laboratory_drape.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kPercent = 100.0;

std::vector<DrapeNode> FindNodes(const Eigen::VectorXd& radius) {
  const std::vector<Fold> folds = FindFolds(radius);
  const Eigen::Matrix2Xd hem = ProfilePolygon(radius);
  std::vector<DrapeNode> nodes;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    const int before = folds[i].valley, after = folds[(i + 1) % folds.size()].valley;
    const double peak = radius[folds[i].peak];
    nodes.push_back({.angle = 2 * M_PI * folds[i].peak / static_cast<double>(radius.size()),
                     .radius = peak,
                     .height = peak - 0.5 * (radius[before] + radius[after]),
                     .width = (hem.col(after) - hem.col(before)).norm()});
  }
  if (nodes.size() == 1) nodes[0].width = 2 * radius[folds[0].valley];  // both valleys are one
  std::sort(nodes.begin(), nodes.end(),
            [](const DrapeNode& a, const DrapeNode& b) { return a.angle < b.angle; });
  return nodes;
}

struct MeanAndDeviation {
  double mean = 0.0, deviation = 0.0;
};
MeanAndDeviation Describe(const std::vector<double>& values) {
  if (values.empty()) return {};
  // A copy: sums over a vector's own memory depend in their last bits on where it lies.
  const Eigen::ArrayXd all =
      Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return {all.mean(), std::sqrt((all - all.mean()).square().mean())};
}

std::vector<double> Spacings(const std::vector<DrapeNode>& nodes) {
  std::vector<double> spacings;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double turn = i + 1 < nodes.size() ? 0.0 : 2 * M_PI;
    spacings.push_back(nodes[(i + 1) % nodes.size()].angle + turn - nodes[i].angle);
  }
  return spacings;
}

constexpr double kDegreesPerRadian = 180.0 / M_PI;
constexpr const char* kDrapeStandard = "BS 5058, ISO 9073-9";

// A text and blanks up to a width in characters of UTF-8.
std::string Padded(const std::string& text, int width) {
  for (const char byte : text) width -= (byte & 0xC0) != 0x80;
  return text + std::string(std::max(0, width), ' ');
}

constexpr const char* kBeyond = "beyond the instrument's range";

// A number without an exponent up to 999,999: "766", "1346", not "1.35e+03".
std::string Plain(double value, int digits) {
  const bool whole = std::abs(value) >= std::pow(10.0, digits) && std::abs(value) < 1e6;
  return whole ? Format("%.0f", value) : Format("%.*g", digits, value);
}

// A number as the instrument of a row prints it.
std::string Reading(const LaboratoryRow& row, double value, int digits) {
  return row.Reads(value) ? Plain(value, digits) : "> " + Plain(*row.reads_up_to, digits);
}

}  // namespace

std::string LaboratoryRow::ValueText() const {
  if (interval && std::isinf(interval->low) && std::isinf(interval->high)) return kOriginNotKnown;
  if (!is_bound()) return Reading(*this, value, 4);
  return (std::isinf(interval->high) ? "at least " : "at most ") + Plain(value, 3);
}

std::string LaboratoryRow::IntervalText() const {
  if (!interval || std::isinf(interval->low) || std::isinf(interval->high)) return "";
  return Reading(*this, interval->low, 3) + " … " + Reading(*this, interval->high, 3);
}

std::string LaboratoryRow::Text() const {
  const std::string ends = IntervalText();
  if (ValueText() == kOriginNotKnown) return name + " " + kOriginNotKnown;
  return name + " " + ValueText() + (unit.empty() ? "" : " " + unit) +
         (ends.empty() ? "" : " (" + ends + ")") + ", " + source;
}

const LaboratoryRow& LaboratorySheet::of(const std::string& key) const {
  std::string keys;
  for (const LaboratoryRow& row : rows) {
    if (row.key == key) return row;
    keys += (keys.empty() ? "" : ", ") + row.key;
  }
  throw InputError(title, "found no quantity '" + key + "', expected one of " + keys);
}

LaboratoryDrape MeasureLaboratoryDrape(const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  LaboratoryDrape drape{.discs = discs, .nodes = FindNodes(radius)};
  const double overhang = discs.specimen - discs.support;
  std::vector<double> heights, severities;
  for (const DrapeNode& node : drape.nodes) {
    heights.push_back(node.height);
    severities.push_back(node.severity());
  }
  const MeanAndDeviation spacing = Describe(Spacings(drape.nodes));
  const MeanAndDeviation severity = Describe(severities);
  const double height = Describe(heights).mean;
  drape.drape_coefficient = kPercent * DrapeCoefficient(ProfileArea(radius), discs);
  drape.spacing_mean = spacing.mean;
  drape.spacing_variation = spacing.mean > 0 ? spacing.deviation / spacing.mean : 0.0;
  drape.severity_mean = severity.mean;
  drape.severity_deviation = severity.deviation;
  drape.distance_ratio = kPercent * (discs.specimen - radius.mean()) / overhang;
  drape.fold_depth_index = kPercent * height / overhang;
  drape.amplitude_ratio = kPercent * 0.5 * height / radius.mean();
  drape.circularity = IsoperimetricRatio(radius);
  return drape;
}

LaboratorySheet DrapeSheet(const LaboratoryDrape& drape, const std::string& title) {
  constexpr double kCentimetres = 100.0;  // in a metre
  LaboratorySheet sheet{title, {}};
  const auto add = [&](const char* key, const char* name, double value, const char* unit,
                       const char* standard = "", const char* source = kMeasured) {
    sheet.rows.push_back({.key = key,
                          .name = name,
                          .value = value,
                          .unit = unit,
                          .source = source,
                          .standard = standard});
  };
  add("specimen_cm", "specimen, diameter", kCentimetres * 2 * drape.discs.specimen, "cm",
      kDrapeStandard, kGiven);
  add("support_cm", "support, diameter", kCentimetres * 2 * drape.discs.support, "cm",
      kDrapeStandard, kGiven);
  add("dc_percent", "drape coefficient DC", drape.drape_coefficient, "%", kDrapeStandard);
  add("nodes", "nodes N", static_cast<double>(drape.nodes.size()), "");
  add("node_spacing_deg", "node spacing, mean", kDegreesPerRadian * drape.spacing_mean, "°");
  add("node_spacing_cv_percent", "node spacing, CV", kPercent * drape.spacing_variation, "%");
  add("node_severity", "node severity, mean", drape.severity_mean, "", "height over width at base");
  add("node_severity_sd", "node severity, SD", drape.severity_deviation, "",
      "height over width at base");
  add("drape_distance_ratio_percent", "drape distance ratio", drape.distance_ratio, "%",
      "Jeong 1998");
  add("fold_depth_index_percent", "fold depth index", drape.fold_depth_index, "%");
  add("amplitude_ratio_percent", "amplitude ratio", drape.amplitude_ratio, "%");
  add("circularity", "circularity", drape.circularity, "", "4πA/L²");
  return sheet;
}

nlohmann::ordered_json RowJson(const LaboratoryRow& row) {
  const auto reading = [&](double value) {
    return row.Reads(value) && std::isfinite(value) ? nlohmann::ordered_json(value)
                                                    : nlohmann::ordered_json();
  };
  nlohmann::ordered_json json = {
      {"key", row.key},
      {"name", row.name},
      {"value", row.is_bound() ? nlohmann::ordered_json() : reading(row.value)},
      {"unit", row.unit},
      {"low", nullptr},
      {"high", nullptr},
      {"text", row.ValueText()},
      {"interval", row.IntervalText()}};
  if (row.interval)
    json.update({{"low", reading(row.interval->low)}, {"high", reading(row.interval->high)}});
  json["source"] = row.source;
  json["standard"] = row.standard;
  if (row.reads_up_to) json["reads_up_to"] = *row.reads_up_to;
  if (!row.Reads(row.value))
    json["note"] = std::string(kBeyond) + ": " + row.ValueText() + " " + row.unit;
  return json;
}

nlohmann::ordered_json SheetJson(const LaboratorySheet& sheet) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const LaboratoryRow& row : sheet.rows) rows.push_back(RowJson(row));
  return {{"title", sheet.title}, {"rows", rows}};
}

nlohmann::ordered_json DrapeSheetJson(const LaboratoryDrape& drape, const std::string& title) {
  constexpr double kMillimetres = 1e3;  // in a metre
  nlohmann::ordered_json json = SheetJson(DrapeSheet(drape, title));
  json["nodes"] = nlohmann::ordered_json::array();
  for (const DrapeNode& node : drape.nodes)
    json["nodes"].push_back({{"angle_deg", kDegreesPerRadian * node.angle},
                             {"radius_mm", kMillimetres * node.radius},
                             {"height_mm", kMillimetres * node.height},
                             {"width_mm", kMillimetres * node.width},
                             {"severity", node.severity()}});
  return json;
}

std::optional<LaboratorySheet> ReadSheet(const std::string& folder, const std::string& name) {
  const std::string path = folder + "/summary.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const nlohmann::json summary = ReadJsonFile(path);
  const nlohmann::json::json_pointer where("/laboratory/" + name);
  if (!summary.is_object() || !summary.contains(where)) return std::nullopt;
  const JsonInput input(summary.at(where), path + ": " + where.to_string());
  LaboratorySheet sheet{input.At("title").String(), {}};
  const JsonInput rows = input.At("rows").ExpectArray();
  for (int i = 0; i < rows.Size(); ++i) {
    const JsonInput row = rows.At(i);
    const auto number = [&](const char* key, double otherwise) {
      return row.At(key).value().is_null() ? otherwise : row.At(key).Number();
    };
    const double infinity = std::numeric_limits<double>::infinity();
    const double low = number("low", -infinity), high = number("high", infinity);
    sheet.rows.push_back({.key = row.At("key").String(),
                          .name = row.At("name").String(),
                          .value = number("value", std::isinf(low) ? high : low),
                          .unit = row.At("unit").String(),
                          .source = row.At("source").String(),
                          .standard = row.At("standard").String()});
    if (!std::isinf(low) || !std::isinf(high)) sheet.rows.back().interval = {low, high};
  }
  return sheet;
}

std::string SheetText(const LaboratorySheet& sheet, const std::set<std::string>& keys) {
  std::string text = "  " + sheet.title + "\n";
  for (const LaboratoryRow& row : sheet.rows) {
    if (!keys.empty() && !keys.contains(row.key)) continue;
    text += "    " + Padded(row.name, 34) + Format(" %9s  ", row.ValueText().c_str()) +
            Padded(row.IntervalText(), 19);
    text += "  " + Padded(row.unit, 11) + " " + row.source;
    text += row.Reads(row.value) ? "\n" : std::string(", ") + kBeyond + "\n";
  }
  return text;
}

}  // namespace drape
