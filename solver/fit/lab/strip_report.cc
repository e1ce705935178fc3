// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab/strip_report.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/material/material_scaling.h"
#include "physics/simulation/textbook.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

constexpr double kDegree = M_PI / 180.0;
constexpr double kMillimetre = 1e-3;

double Deviation(const StripReport& report, std::size_t point) {
  return (report.computed[point] - report.measurement.points[point].reading) /
         report.measurement.sigma;
}

ordered_json PointJson(const StripReport& report, std::size_t i) {
  const LabPoint& point = report.measurement.points[i];
  const double computed = report.computed[i];
  if (report.measurement.kind == LabMeasurementKind::kTensile)
    return {{"force", point.set},
            {"stretch", point.reading},
            {"stretch_computed", computed},
            {"residual", Deviation(report, i)}};
  const BendingEstimate read = EstimateBending(point.set, point.reading, report.density),
                        fitted = EstimateBending(point.set, computed, report.density);
  return {{"length", point.set},
          {"angle", point.reading},
          {"angle_computed", computed},
          {"residual", Deviation(report, i)},
          {"bending_length_m", read.length},
          {"bending_length_computed_m", fitted.length},
          {"flexural_rigidity", read.rigidity},
          {"flexural_rigidity_computed", fitted.rigidity}};
}

std::string PointLine(const StripReport& report, std::size_t i) {
  const LabPoint& point = report.measurement.points[i];
  std::string line =
      Format("%-28.28s %5g deg", report.measurement.name.c_str(), report.measurement.direction);
  if (report.measurement.kind == LabMeasurementKind::kTensile)
    return line + Format("  force %8.4g N   stretch %9.4f %9.4f %8.2f\n", point.set, point.reading,
                         report.computed[i], Deviation(report, i));
  const BendingEstimate read = EstimateBending(point.set, point.reading, report.density),
                        fitted = EstimateBending(point.set, report.computed[i], report.density);
  return line +
         Format("  length %6.4g mm  angle  %9.2f %9.2f %8.2f  c %.3g mm, G %.4g, fitted %.4g N m\n",
                point.set / kMillimetre, point.reading, report.computed[i], Deviation(report, i),
                read.length / kMillimetre, read.rigidity, fitted.rigidity);
}

}  // namespace

BendingEstimate EstimateBending(double overhang, double angle, double density) {
  if (!(angle > 0.0 && angle < 90.0)) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none};
  }
  const double length = overhang / std::cbrt(HeavyElasticaGamma(angle * kDegree));
  return {length, density * kStandardGravity * length * length * length};
}

std::vector<StripReport> ReportStrips(const StripResiduals& strips, const MaterialField& material) {
  Eigen::VectorXd readings;
  if (!strips.Clone().Compute(material, &readings)) return {};
  std::vector<StripReport> reports;
  int next = 0;
  for (const LabMeasurement& measurement : strips.measurements()) {
    const auto count = static_cast<Eigen::Index>(measurement.points.size());
    const Eigen::VectorXd own = readings.segment(next, count);
    reports.push_back({measurement, std::vector<double>(own.begin(), own.end()), material.density});
    next += static_cast<int>(count);
  }
  return reports;
}

ordered_json StripsJson(const std::vector<StripReport>& reports) {
  ordered_json json = ordered_json::array();
  for (const StripReport& report : reports) {
    ordered_json measurement = {{"file", report.measurement.file},
                                {"name", report.measurement.name},
                                {"test", ToString(report.measurement.kind)},
                                {"direction", report.measurement.direction},
                                {"sigma", report.measurement.sigma}};
    measurement["points"] = ordered_json::array();
    for (std::size_t i = 0; i < report.computed.size(); ++i)
      measurement["points"].push_back(PointJson(report, i));
    json.push_back(std::move(measurement));
  }
  return json;
}

std::string StripTable(const std::vector<StripReport>& reports) {
  if (reports.empty()) return "";
  std::string table = Format("%-28s %9s  %-26s %9s %9s %8s\n", "test", "direction", "set, measured",
                             "measured", "fitted", "/ sigma");
  for (const StripReport& report : reports)
    for (std::size_t i = 0; i < report.computed.size(); ++i) table += PointLine(report, i);
  return table;
}

}  // namespace drape
