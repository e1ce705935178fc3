// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observed/lab_measurement.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/material/material_scaling.h"
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

}  // namespace

std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  if (input.Has("raw_data")) return ReadRawData(input, path);
  if (!input.Has("material") || !input.Has("schema")) return {ReadLabMeasurement(input, path)};
  return ReadU3m(input, path);
}

}  // namespace drape
