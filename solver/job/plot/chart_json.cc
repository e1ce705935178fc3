// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/chart_json.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/text_format.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// In the order of the enums.
constexpr const char* kMarks[] = {"line",       "steps", "line_points", "points",
                                  "error_bars", "bars",  "squares",     "polygons"};
constexpr const char* kSymbols[] = {"disc",          "square",   "triangle", "diamond",
                                    "triangle_down", "pentagon", "ring",     "cross"};
constexpr const char* kAligns[] = {"left", "centre", "right"};

Json NumberJson(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(Format("%.6g", value).c_str(), nullptr);
}

Json PointJson(const Eigen::Vector2d& point) {
  return Json::array({NumberJson(point.x()), NumberJson(point.y())});
}

Json AxisJson(const ChartAxis& axis) {
  Json json = {{"label", axis.label}};
  if (axis.log) json["log"] = true;
  if (axis.range)
    json["range"] = Json::array({NumberJson(axis.range->first), NumberJson(axis.range->second)});
  if (!axis.ticks) return json;
  json["ticks"] = Json::array();
  for (const auto& [value, text] : *axis.ticks)
    json["ticks"].push_back(Json::array({NumberJson(value), text}));
  return json;
}

Json SeriesJson(const ChartSeries& series) {
  Json json = {{"mark", kMarks[static_cast<int>(series.mark)]}};
  if (!series.title.empty()) json["title"] = series.title;
  if (!series.colour.empty()) json["colour"] = series.colour;
  if (series.symbol != Symbol::kDisc) json["symbol"] = kSymbols[static_cast<int>(series.symbol)];
  if (series.size != 1.0) json["size"] = NumberJson(series.size);
  if (series.width != 2.0) json["width"] = NumberJson(series.width);
  if (series.dashed) json["dashed"] = true;
  json["points"] = Json::array();
  for (const Eigen::Vector2d& point : series.points) json["points"].push_back(PointJson(point));
  for (const double value : series.values) json["values"].push_back(NumberJson(value));
  return json;
}

Json LabelJson(const ChartLabel& label) {
  Json json = {{"text", label.text},
               {"at", PointJson(label.at)},
               {"align", kAligns[static_cast<int>(label.align)]}};
  if (label.in_picture) json["in_picture"] = true;
  return json;
}

Json ChartJson(const Chart& chart) {
  Json json = {{"title", chart.title}, {"x", AxisJson(chart.x)}, {"y", AxisJson(chart.y)}};
  if (!chart.colour.label.empty() || chart.colour.log) json["colour"] = AxisJson(chart.colour);
  if (chart.equal_units) json["equal_units"] = true;
  if (!chart.grid) json["grid"] = false;
  json["series"] = Json::array();
  for (const ChartSeries& series : chart.series) json["series"].push_back(SeriesJson(series));
  for (const ChartLabel& label : chart.labels) json["labels"].push_back(LabelJson(label));
  return json;
}

}  // namespace

Json PictureJson(const Picture& picture) {
  Json json = {{"format", "drapefit-chart"},
               {"version", 1},
               {"title", picture.title},
               {"columns", picture.columns},
               {"charts", Json::array()}};
  for (const Chart& chart : picture.charts) json["charts"].push_back(ChartJson(chart));
  return json;
}

std::string PictureText(const Picture& picture) {
  return PictureJson(picture).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string ChartPath(const std::string& picture_path) {
  return std::filesystem::path(picture_path).replace_extension(".chart.json").string();
}

}  // namespace drape
