// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab_measurement.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/textbook.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr double kMostWidths = 40.0;  // of a tensile strip: its mesh has square cells
constexpr double kLongest = 10.0;     // of a strip or its width [m]: what is above is no metres

// The keys of a point and the range of a reading, ends excluded.
struct Form {
  const char* set;
  const char* reading;
  double most_set, least_reading, most_reading;
};

Form MeasurementForm(LabMeasurementKind kind) {
  if (kind == LabMeasurementKind::kCantilever) return {"length", "angle", kLongest, 0.0, 90.0};
  constexpr double kMostForce = 1e6;  // [N]
  return {"force", "stretch", kMostForce, 0.9, 5.0};
}

double NumberBetween(const JsonInput& input, double least, double most) {
  const double value = input.Number();
  if (value > least && value < most) return value;
  nlohmann::json low = least, high = most;
  input.Fail("a number > " + low.dump() + " and < " + high.dump());
}

// A length of a strip [m].
double Length(const JsonInput& input) {
  const double length = NumberBetween(input, 0.0, kLongest);
  CheckUsual(input.Name(), length, "m", 0.005, 0.5);
  return length;
}

// The weighed mass of a fabric [kg/m²], which a file states in g/m²; 0: it does not.
double Density(const JsonInput& file, const char* key) {
  if (!file.Has(key) || file.At(key).value().is_null()) return 0.0;
  const double mass = file.At(key).NumberWithin(0.0, 1e4);
  if (mass > 0.0) CheckUsual(file.At(key).Name(), mass, "g/m2", 10.0, 1500.0);
  return mass / 1e3;
}

LabPoint ReadPoint(const JsonInput& input, const Form& form) {
  input.ExpectKeys({form.set, form.reading});
  return {NumberBetween(input.At(form.set), 0.0, form.most_set),
          NumberBetween(input.At(form.reading), form.least_reading, form.most_reading)};
}

LabMeasurement ReadLabMeasurement(const JsonInput& input, const std::string& path) {
  constexpr double kLeastSigma = 1e-8, kMostSigma = 1e4;  // of degrees or stretch
  LabMeasurement measurement;
  measurement.file = path;
  measurement.name = fs::path(path).stem().string();
  const JsonInput test = input.At("test");
  measurement.kind = ParseName<LabMeasurementKind>(test.String(), test.Name());
  const bool tensile = measurement.kind == LabMeasurementKind::kTensile;
  std::vector<std::string> keys = {"test", "direction", "width", "sigma", "points"};
  if (tensile) keys.push_back("length");
  input.ExpectKeys(keys);
  measurement.direction = NumberBetween(input.At("direction"), -360.0, 360.0);
  if (measurement.direction != 0.0)
    CheckUsual(input.At("direction").Name(), std::abs(measurement.direction), "deg", 2.0, 360.0);
  if (tensile) measurement.length = Length(input.At("length"));
  if (tensile || input.Has("width")) measurement.width = Length(input.At("width"));
  if (tensile && !(measurement.length >= measurement.width &&
                   measurement.length <= kMostWidths * measurement.width))
    input.At("length").Fail("between one width and " + std::to_string(int(kMostWidths)) +
                            " widths of the strip");
  measurement.sigma = input.At("sigma").NumberWithin(kLeastSigma, kMostSigma);
  const JsonInput points = input.At("points");
  if (points.ExpectArray().Size() == 0) points.Fail("at least one point");
  for (int i = 0; i < points.Size(); ++i)
    measurement.points.push_back(ReadPoint(points.At(i), MeasurementForm(measurement.kind)));
  std::stable_sort(measurement.points.begin(), measurement.points.end(),
                   [](const LabPoint& a, const LabPoint& b) { return a.set < b.set; });
  if (tensile) {
    const LabPoint& last = measurement.points.back();
    const double force = (last.reading - 1.0) * measurement.width;  // at a stiffness of 1 N/m
    if (force > 0.0)
      CheckUsual(points.Name() + ": largest force", last.set, "N", 2.0 * force, 1e5 * force);
    return measurement;
  }
  double steepest = 0.0;
  for (const LabPoint& point : measurement.points) steepest = std::max(steepest, point.reading);
  CheckUsual(points.Name() + ": largest angle", steepest, "deg", 2.0, 90.0);
  CheckUsual(points.Name() + ": largest length", measurement.points.back().set, "m", 0.005, 0.5);
  return measurement;
}

constexpr double kCentimetre = 0.01;                              // [m]
constexpr double kGramForce = 1e-3 * kStandardGravity;            // [N]
constexpr double kMostDistance = 100.0, kMostForce = 1e5;         // of a sample [cm], [gf]
constexpr int kPoints = 10, kFirstSamples = 5, kFewSamples = 20;  // of a loading

struct FabStrip {
  const char* key;
  const char* suffix;
  double direction;  // [°]
};
constexpr FabStrip kStrips[] = {{"W", "_weft", 0.0}, {"B", "_bias", 45.0}, {"L", "_warp", 90.0}};

struct Sample {
  double distance, force;  // [m], [N]
};
using Cycle = std::vector<Sample>;

Cycle ReadCycle(const JsonInput& input) {
  const int size = input.ExpectArray().Size();
  if (size % 2 != 0) input.Fail("pairs of distance and force");
  Cycle cycle;
  for (int i = 0; i < size; i += 2)
    cycle.push_back({kCentimetre * input.At(i).NumberWithin(0.0, kMostDistance),
                     kGramForce * input.At(i + 1).NumberWithin(-kMostForce, kMostForce)});
  return cycle;
}

// The stretching part of a cycle that reaches the largest force.
Cycle FindLoading(const JsonInput& tree) {
  Cycle loading;
  double largest = 0.0;
  for (int i = 0; i < tree.ExpectArray().Size(); ++i) {
    Cycle cycle = ReadCycle(tree.At(i));
    if (static_cast<int>(cycle.size()) < kFewSamples) continue;
    if (cycle.back().distance <= cycle.front().distance) continue;
    if (cycle.back().force <= largest) continue;
    largest = cycle.back().force;
    loading = std::move(cycle);
  }
  if (loading.empty())
    tree.Fail("a cycle of at least " + std::to_string(kFewSamples) +
              " samples in which distance and force rise");
  return loading;
}

// Means over ten equal parts of the force.
std::vector<LabPoint> MakePoints(const Cycle& loading, double largest_force, double zero_force) {
  const double rest = loading.front().distance;
  std::vector<LabPoint> points;
  for (int k = 0; k < kPoints; ++k) {
    const double low = largest_force * (k + 0.5) / kPoints, high = low + largest_force / kPoints;
    LabPoint sum;
    int count = 0;
    for (const Sample& sample : loading) {
      const double force = sample.force - zero_force;
      if (force < low || force >= high) continue;
      sum.set += force;
      sum.reading += sample.distance / rest;
      ++count;
    }
    if (count > 0) points.push_back({sum.set / count, sum.reading / count});
  }
  return points;
}

LabMeasurement ReadStrip(const JsonInput& input, const std::string& path, const FabStrip& strip) {
  LabMeasurement measurement;
  measurement.file = path;
  measurement.name = fs::path(path).stem().string() + strip.suffix;
  measurement.kind = LabMeasurementKind::kTensile;
  measurement.direction = strip.direction;
  measurement.width = kCentimetre * input.At("width").NumberWithin(1.0, 8.0);
  const JsonInput tree = input.At("samplesTree");
  const Cycle loading = FindLoading(tree);
  measurement.length = loading.front().distance;
  if (measurement.length < measurement.width)
    tree.Fail("strips that are at least as long as wide, " +
              std::to_string(measurement.width / kCentimetre) + " cm");
  double zero_force = 0.0;
  for (int i = 0; i < kFirstSamples; ++i) zero_force += loading[i].force / kFirstSamples;
  measurement.points = MakePoints(loading, loading.back().force - zero_force, zero_force);
  if (measurement.points.empty()) tree.Fail("a force that rises over a cycle");
  const double strain = measurement.points.back().reading - 1.0;
  if (!(strain > 0.0)) tree.Fail("a strip that is stretched");
  measurement.sigma = std::max(1e-3, 0.01 * strain);
  return measurement;
}

std::vector<LabMeasurement> ReadRawData(const JsonInput& file, const std::string& path) {
  const JsonInput raw = file.At("raw_data");
  std::vector<LabMeasurement> strips;
  for (const FabStrip& strip : kStrips)
    if (raw.Has(strip.key)) strips.push_back(ReadStrip(raw.At(strip.key).At("S2"), path, strip));
  if (strips.empty()) raw.Fail("the strips \"W\", \"B\" or \"L\"");
  for (LabMeasurement& strip : strips) strip.density = Density(raw, "M");
  return strips;
}

// The file of raw data beside a .u3m, whose own weight comes first.
std::vector<LabMeasurement> ReadU3m(const JsonInput& material, const std::string& path) {
  const JsonInput physics = material.At("material").At("physics");
  const double density = Density(physics, "weight");
  const JsonInput fab = physics.At("devices").At("fab");
  const std::string raw = (fs::path(path).parent_path() / fab.String()).string();
  std::error_code unknown;
  const fs::file_type kind = fs::status(raw, unknown).type();
  if (kind == fs::file_type::not_found || kind == fs::file_type::directory)
    fab.Fail("the path of a file of raw data, relative to this one");
  const nlohmann::json document = ReadJsonFile(raw);
  std::vector<LabMeasurement> strips = ReadRawData(JsonInput(document, raw), raw);
  if (density > 0.0 && density != strips[0].density && strips[0].density > 0.0)
    NoteInput(path, Format("weight is %g g/m2, which is used; M of %s is %g", 1e3 * density,
                           raw.c_str(), 1e3 * strips[0].density));
  for (LabMeasurement& strip : strips)
    if (density > 0.0) strip.density = density;
  return strips;
}

constexpr double kDegree = M_PI / 180.0;
const double kRowByEdge = std::sqrt(0.75);  // of equilateral triangles

// A cantilever's lattices: edges along the strip, and across it.
constexpr int kAlong = 64, kAcross = 4;
// Where a beam of the same overhang is clamped, from the held end: in edges with rows along, in
// rows with rows across. The clamp holds the width flat, which stiffens a strip that is free to
// curl as if it were shorter by .058 of its width. Where a hinge bends over its held wing too, the
// strip bends half a row inside the clamp; .8 and .9 include both (strip_simulation_test).
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

}  // namespace

std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  if (input.Has("raw_data")) return ReadRawData(input, path);
  if (!input.Has("material") || !input.Has("schema")) return {ReadLabMeasurement(input, path)};
  return ReadU3m(input, path);
}

StripSimulation::StripSimulation(const LabMeasurement& measurement, int point, const Law& law)
    : kind_(measurement.kind) {
  const double set = measurement.points[point].set, direction = measurement.direction * kDegree;
  if (kind_ == LabMeasurementKind::kTensile) {
    const int along =
        std::max(2, int(std::lround(kPulledAcross * measurement.length / measurement.width)));
    load_ = set;
    tolerance_ = std::max(kPulledTolerance, kLeastForce / set);
    AddLattice(Laid(MakeStrip(measurement.length, measurement.width, along, kPulledAcross), 0.0,
                    direction),
               UniaxialScene(measurement.length, set), law, 0.0);
    return;
  }
  tolerance_ = kFallenTolerance;
  const ClampEdge clamp = FindClampEdge(law);
  const double edge = set / (kAlong + 1.0 - clamp.along);
  AddLattice(Laid(MakeStrip((kAlong + 1) * edge, kAcross * kRowByEdge * edge, kAlong + 1, kAcross),
                  0.0, direction),
             MakeCantileverScene(edge), law, clamp.along * edge);
  const int rows = static_cast<int>(std::lround(kAlong / kRowByEdge)) + 1;
  const double row = set / (rows - clamp.across), across = row / kRowByEdge;
  AddLattice(Laid(MakeStrip(kAcross * across, rows * row, kAcross, rows), -M_PI / 2, direction),
             MakeCantileverScene(row), law, clamp.across * row);
}

StripSimulation StripSimulation::Clone() const {
  StripSimulation clone(kind_);
  clone.load_ = load_;
  clone.tolerance_ = tolerance_;
  for (const Lattice& lattice : lattices_)
    clone.lattices_.push_back({lattice.solver.Clone(), lattice.clamp, lattice.end, lattice.x});
  return clone;
}

void StripSimulation::StartLike(const StripSimulation& neighbour) {
  for (std::size_t i = 0; i < lattices_.size(); ++i) {
    Lattice& lattice = lattices_[i];
    const Lattice& like = neighbour.lattices_[i];
    if (lattice.x.size() > 0 || like.x.size() == 0) continue;
    lattice.x = like.x * (RestEnd(lattice) / RestEnd(like));
  }
}

double StripSimulation::RestEnd(const Lattice& lattice) {
  return lattice.solver.model().mesh.rest_x[3 * lattice.end.front()];
}

void StripSimulation::AddLattice(Mesh mesh, Scene scene, const Law& law, double clamp) {
  const auto model = std::make_shared<const ClothModel>(std::move(mesh), std::move(scene), law);
  const Eigen::VectorXd& x = model->mesh.rest_x;
  const int count = model->mesh.num_vertices();
  double end = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) end = std::max(end, x[3 * i]);
  Lattice lattice{StepSolver(model), clamp, {}, {}};
  for (int i = 0; i < count; ++i)
    if (x[3 * i] > end - 1e-9) lattice.end.push_back(i);
  lattices_.push_back(std::move(lattice));
}

MaterialField StripSimulation::OnStrip(const MaterialField& material) const {
  MaterialField strip = material;
  if (kind_ == LabMeasurementKind::kCantilever) {
    strip.density *= 1.0 - kHingePoisson * kHingePoisson;
  } else {
    strip.bend = LinearMaterial(1.0, kFlat, 1.0).bend;
    // Weighs as much as its load, to which the tolerance of an equilibrium is relative.
    strip.density = 1.0;
    strip.density = load_ / CharacteristicForce(lattices_.front().solver.model(), strip);
  }
  return strip;
}

// Newton from the last shape; where that fails, from rest.
bool StripSimulation::Settle(Lattice& lattice, const MaterialField& strip) const {
  EquilibriumOptions options;
  options.max_iterations = 60;
  options.tolerance = tolerance_;
  options.shift.most = kMostShift;
  if (kind_ == LabMeasurementKind::kTensile)
    options.residual_regime = std::numeric_limits<double>::infinity();
  if (lattice.x.size() > 0) {
    EquilibriumResult near = SolveEquilibrium(lattice.solver, strip, lattice.x, options);
    if (near.status == EquilibriumStatus::kStable) {
      lattice.x = std::move(near.x);
      return true;
    }
  }
  EquilibriumResult rest = SolveFromRest(lattice.solver, strip, options);
  if (rest.status != EquilibriumStatus::kStable) return false;
  lattice.x = std::move(rest.x);
  return true;
}

double StripSimulation::Reading(const Lattice& lattice, Eigen::Vector3d* by_tip) const {
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();
  for (const int i : lattice.end) tip += lattice.x.segment<3>(3 * i) / double(lattice.end.size());
  if (kind_ == LabMeasurementKind::kTensile) {
    const double length = RestEnd(lattice);
    *by_tip = Eigen::Vector3d::UnitX() / length;
    return tip.x() / length;
  }
  const double reach = tip.x() - lattice.clamp, drop = -tip.z();
  *by_tip = Eigen::Vector3d(-drop, 0.0, -reach) / (reach * reach + drop * drop) / kDegree;
  return std::atan2(drop, reach) / kDegree;
}

bool StripSimulation::Differentiate(Lattice& lattice, const MaterialField& strip,
                                    const Eigen::Vector3d& by_tip,
                                    Eigen::VectorXd* by_log_entry) const {
  RowMatrix seed = RowMatrix::Zero(lattice.x.size(), 1);
  for (const int i : lattice.end) seed.block<3, 1>(3 * i, 0) = by_tip / double(lattice.end.size());
  MaterialGradient gradient;
  if (!EquilibriumAdjoint(lattice.solver, strip, lattice.x, seed, &gradient)) return false;
  *by_log_entry = gradient.Contract(strip).col(0);
  // The rigidity that keeps a pulled strip flat is not the material's.
  if (kind_ == LabMeasurementKind::kTensile) by_log_entry->tail(kBendEntries).setZero();
  return true;
}

bool StripSimulation::Predict(const MaterialField& material, double* reading,
                              Eigen::VectorXd* by_log_entry) {
  const MaterialField strip = OnStrip(material);
  const double share = 1.0 / double(lattices_.size());
  *reading = 0.0;
  if (by_log_entry != nullptr) by_log_entry->setZero(kMaterialEntries);
  for (Lattice& lattice : lattices_) {
    if (!Settle(lattice, strip)) return false;
    Eigen::Vector3d by_tip;
    *reading += share * Reading(lattice, &by_tip);
    Eigen::VectorXd gradient;
    if (by_log_entry == nullptr) continue;
    if (!Differentiate(lattice, strip, by_tip, &gradient)) return false;
    *by_log_entry += share * gradient;
  }
  return true;
}

StripResiduals::StripResiduals(std::vector<LabMeasurement> measurements, const Law& law)
    : measurements_(std::move(measurements)) {
  for (const LabMeasurement& measurement : measurements_)
    for (int point = 0; point < static_cast<int>(measurement.points.size()); ++point) {
      strips_.emplace_back(measurement, point, law);
      first_of_measurement_.push_back(point == 0);
    }
}

StripResiduals StripResiduals::Clone() const {
  StripResiduals clone;
  clone.measurements_ = measurements_;
  clone.first_of_measurement_ = first_of_measurement_;
  for (const StripSimulation& strip : strips_) clone.strips_.push_back(strip.Clone());
  return clone;
}

bool StripResiduals::Compute(const MaterialField& material, Eigen::VectorXd* readings,
                             RowMatrix* by_log_entry) {
  readings->resize(num_points());
  if (by_log_entry != nullptr) by_log_entry->resize(num_points(), kMaterialEntries);
  for (int i = 0; i < num_points(); ++i) {
    if (!first_of_measurement_[i]) strips_[i].StartLike(strips_[i - 1]);
    Eigen::VectorXd gradient;
    if (!strips_[i].Predict(material, &(*readings)[i],
                            by_log_entry == nullptr ? nullptr : &gradient))
      return false;
    if (by_log_entry != nullptr) by_log_entry->row(i) = gradient.transpose();
  }
  return true;
}

bool StripResiduals::Evaluate(const MaterialParametrisation& parametrisation,
                              const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                              RowMatrix* jacobian) {
  RowMatrix by_log_entry;
  if (!Compute(parametrisation.Material(theta), residual,
               jacobian == nullptr ? nullptr : &by_log_entry)) {
    return false;
  }
  if (jacobian != nullptr) *jacobian = by_log_entry * parametrisation.LogEntriesByTheta(theta);
  int row = 0;
  for (const LabMeasurement& measurement : measurements_)
    for (const LabPoint& point : measurement.points) {
      (*residual)[row] = ((*residual)[row] - point.reading) / measurement.sigma;
      if (jacobian != nullptr) jacobian->row(row) /= measurement.sigma;
      ++row;
    }
  return true;
}

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
