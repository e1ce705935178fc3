// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab/fab_measurement.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/material/material_scaling.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

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
  return strips;
}

// The file of raw data beside a .u3m.
std::string FindRawData(const JsonInput& material, const std::string& path) {
  const JsonInput devices = material.At("material").At("physics").At("devices");
  return (fs::path(path).parent_path() / devices.At("fab").String()).string();
}

}  // namespace

std::vector<LabMeasurement> ReadLabMeasurements(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  if (input.Has("raw_data")) return ReadRawData(input, path);
  if (!input.Has("material") || !input.Has("schema")) return {ReadLabMeasurement(path)};
  const std::string raw = FindRawData(input, path);
  const nlohmann::json raw_document = ReadJsonFile(raw);
  return ReadRawData(JsonInput(raw_document, raw), raw);
}

}  // namespace drape
