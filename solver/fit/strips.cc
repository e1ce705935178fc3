// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/strips.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "losses/readout/place_readouts.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/textbook.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kDegree = M_PI / 180.0;
const double kRowByEdge = std::sqrt(0.75);  // of equilateral triangles

// A cantilever's lattices: edges along the strip, and across it.
constexpr int kAlong = 64, kAcross = 4;
// Where a beam of the same overhang is clamped, from the held end: in edges with rows along, in
// rows with rows across. The clamp holds the width flat, which stiffens a strip that is free to
// curl as if it were shorter by .058 of its width. Where a hinge bends over its held wing too, the
// strip bends half a row inside the clamp; .8 and .9 include both (strips_test).
struct ClampEdge {
  double along, across;
};
ClampEdge FindClampEdge(const Law& law) {
  if (law.held_wing_bends()) return {0.8, 0.9};
  constexpr double kFlatLayer = 0.058, kMeanHeldLine = 0.75;  // rows end at 1 and at 1/2 in turn
  return {kMeanHeldLine + kFlatLayer * kAcross * kRowByEdge,
          1.0 + kFlatLayer * kAcross / kRowByEdge};
}

// Springs of the clamp [N/m]: it turns by 1e-5, and their rounding stays below the tolerance.
constexpr double kClampStiffness = 1e5;
constexpr double kFallenTolerance = 1e-8;  // ‖f‖ / weight

// A strip's vertices are so light that μM matters to its membrane at this shift only [s⁻²].
constexpr double kMostShift = 1e12;

// A pulled strip: edges across, and the plate rigidity that keeps it flat [N·m].
constexpr int kPulledAcross = 8;
constexpr double kFlat = 1.0;
// ‖f‖ / load, but no less than this force [N], to which the springs of the clamp are rounded.
constexpr double kPulledTolerance = 1e-11, kLeastForce = 5e-11;

Scene MakeCantileverScene(double clamp) {
  Scene scene = CantileverScene(clamp, kStandardGravity);
  scene.handles->stiffness = kClampStiffness;
  return scene;
}

using nlohmann::ordered_json;

constexpr double kMetresPerMillimetre = 1e-3;

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
                point.set / kMetresPerMillimetre, point.reading, report.computed[i],
                Deviation(report, i), read.length / kMetresPerMillimetre, read.rigidity,
                fitted.rigidity);
}

// The vertices of the end of a strip, whose mean is the tip.
std::vector<int> FindEnd(const Mesh& mesh) {
  const Eigen::VectorXd& x = mesh.rest_x;
  double end = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < mesh.num_vertices(); ++i) end = std::max(end, x[3 * i]);
  std::vector<int> vertices;
  for (int i = 0; i < mesh.num_vertices(); ++i)
    if (x[3 * i] > end - 1e-9) vertices.push_back(i);
  return vertices;
}

// The material of a pulled strip, which is kept flat and weighs as much as its load, to which the
// tolerance of an equilibrium is relative.
MaterialField KeptFlat(const ClothModel& model, double load, const MaterialField& fabric) {
  MaterialField strip = fabric;
  strip.bend = LinearMaterial(1.0, kFlat, 1.0).bend;
  strip.density = 1.0;
  strip.density = load / CharacteristicForce(model, strip);
  return strip;
}

}  // namespace

Strips::Strips(std::vector<LabMeasurement> measurements, const Law& law)
    : measurements_(std::move(measurements)) {
  for (const LabMeasurement& measurement : measurements_)
    for (const LabPoint& point : measurement.points) {
      points_.push_back(measurement.kind == LabMeasurementKind::kTensile
                            ? MakeTensile(measurement, point, law)
                            : MakeCantilever(measurement, point, law));
      points_.back().follows = &point != &measurement.points.front();
    }
}

Strips::Point Strips::MakeTensile(const LabMeasurement& measurement, const LabPoint& point,
                                  const Law& law) {
  const int along =
      std::max(2, int(std::lround(kPulledAcross * measurement.length / measurement.width)));
  const Mesh mesh = MakeStrip(measurement.length, measurement.width, along, kPulledAcross);
  const auto model =
      std::make_shared<const ClothModel>(Laid(mesh, 0.0, measurement.direction * kDegree),
                                         UniaxialScene(measurement.length, point.set), law);
  const std::vector<int> end = FindEnd(model->mesh);
  const double rest_end = model->mesh.rest_x[3 * end.front()];
  return {
      .kind = measurement.kind,
      .reading = point.reading,
      .sigma = measurement.sigma,
      .tolerance = std::max(kPulledTolerance, kLeastForce / point.set),
      .load = point.set,
      .lattices = {{model, std::make_shared<TipReadout>(end, Eigen::Vector3d::UnitX(), rest_end)}}};
}

Strips::Point Strips::MakeCantilever(const LabMeasurement& measurement, const LabPoint& point,
                                     const Law& law) {
  Point made{.kind = measurement.kind,
             .reading = point.reading,
             .sigma = measurement.sigma,
             .tolerance = kFallenTolerance};
  // clamp: of a beam of the same overhang, x [m]; held: by the scene.
  const auto add = [&](const Mesh& mesh, double place, double held, double clamp) {
    const auto model = std::make_shared<const ClothModel>(
        Laid(mesh, place, measurement.direction * kDegree), MakeCantileverScene(held), law);
    made.lattices.push_back({model, std::make_shared<AngleReadout>(FindEnd(model->mesh),
                                                                   clamp * Eigen::Vector3d::UnitX(),
                                                                   Eigen::Vector3d::UnitX())});
  };
  const ClampEdge clamp = FindClampEdge(law);
  const double edge = point.set / (kAlong + 1.0 - clamp.along);
  add(MakeStrip((kAlong + 1) * edge, kAcross * kRowByEdge * edge, kAlong + 1, kAcross), 0.0, edge,
      clamp.along * edge);
  const int rows = static_cast<int>(std::lround(kAlong / kRowByEdge)) + 1;
  const double row = point.set / (rows - clamp.across);
  add(MakeStrip(kAcross * row / kRowByEdge, rows * row, kAcross, rows), -M_PI / 2, row,
      clamp.across * row);
  return made;
}

std::vector<RolloutBlock> Strips::MakeBlocks(const std::atomic<bool>* cancel) const {
  std::vector<RolloutBlock> blocks;
  for (const Point& point : points_) {
    RolloutBlock block;
    Sight sight{
        .readouts = {}, .data = Eigen::VectorXd::Constant(1, point.reading), .sigma = point.sigma};
    for (const Lattice& lattice : point.lattices) {
      block.runs.push_back(OwnRun(lattice.model));
      block.runs.back().weight = 1.0 / double(point.lattices.size());
      sight.readouts.push_back(lattice.readout);
    }
    block.sights = {std::move(sight)};
    block.equilibrium = {.tolerance = point.tolerance, .max_iterations = 60, .cancel = cancel};
    block.equilibrium.shift.most = kMostShift;
    block.is_unique = true;
    block.starts_like_previous = point.follows;
    if (point.kind == LabMeasurementKind::kCantilever) {
      block.prepare = [](const MaterialField& fabric) {
        MaterialField strip = fabric;
        strip.density *= 1.0 - kHingePoisson * kHingePoisson;
        return strip;
      };
    } else {
      block.equilibrium.residual_regime = std::numeric_limits<double>::infinity();
      block.has_own_bend = true;  // the rigidity that keeps a pulled strip flat
      block.prepare = [model = point.lattices.front().model, load = point.load](
                          const MaterialField& fabric) { return KeptFlat(*model, load, fabric); };
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

std::optional<Eigen::VectorXd> Strips::Compute(const MaterialField& material) const {
  const TableParametrisation fixed(material, ParameterTying::kScales);
  RolloutResiduals residuals(&fixed, MakeBlocks(), {});
  residuals.PrepareForEvaluation(false, true);
  if (!residuals.all_valid()) return std::nullopt;
  Eigen::VectorXd readings(num_points());
  for (int i = 0; i < num_points(); ++i)
    readings[i] = points_[i].reading + points_[i].sigma * residuals.residual(i)[0];
  return readings;
}

BendingEstimate EstimateBending(double overhang, double angle, double density) {
  if (!(angle > 0.0 && angle < 90.0)) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none};
  }
  const double length = overhang / std::cbrt(HeavyElasticaGamma(angle * kDegree));
  return {length, density * kStandardGravity * length * length * length};
}

std::vector<StripReport> ReportStrips(const Strips& strips, const MaterialField& material) {
  const std::optional<Eigen::VectorXd> readings = strips.Compute(material);
  if (!readings) return {};
  std::vector<StripReport> reports;
  int next = 0;
  for (const LabMeasurement& measurement : strips.measurements()) {
    const auto count = static_cast<Eigen::Index>(measurement.points.size());
    const Eigen::VectorXd own = readings->segment(next, count);
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
