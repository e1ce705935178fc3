// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/lab/lab_measurement.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

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

LabMeasurementKind FindKind(const JsonInput& input) {
  const std::string name = input.String();
  for (const LabMeasurementKind kind :
       {LabMeasurementKind::kCantilever, LabMeasurementKind::kTensile})
    if (name == ToString(kind)) return kind;
  input.Fail("\"cantilever\" or \"tensile\"");
}

LabPoint ReadPoint(const JsonInput& input, const Form& form) {
  input.ExpectKeys({form.set, form.reading});
  return {NumberBetween(input.At(form.set), 0.0, form.most_set),
          NumberBetween(input.At(form.reading), form.least_reading, form.most_reading)};
}

}  // namespace

const char* ToString(LabMeasurementKind kind) {
  return kind == LabMeasurementKind::kCantilever ? "cantilever" : "tensile";
}

LabMeasurement ReadLabMeasurement(const std::string& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonInput input(document, path);
  constexpr double kLeastSigma = 1e-8, kMostSigma = 1e4;  // of degrees or stretch
  LabMeasurement measurement;
  measurement.file = path;
  measurement.name = std::filesystem::path(path).stem().string();
  measurement.kind = FindKind(input.At("test"));
  const bool tensile = measurement.kind == LabMeasurementKind::kTensile;
  std::vector<std::string> keys = {"test", "direction", "width", "sigma", "points"};
  if (tensile) keys.push_back("length");
  input.ExpectKeys(keys);
  measurement.direction = NumberBetween(input.At("direction"), -360.0, 360.0);
  if (tensile) measurement.length = NumberBetween(input.At("length"), 0.0, kLongest);
  if (tensile || input.Has("width"))
    measurement.width = NumberBetween(input.At("width"), 0.0, kLongest);
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
  return measurement;
}

void WriteLabMeasurement(const std::string& path, const LabMeasurement& measurement) {
  nlohmann::ordered_json document = {{"test", ToString(measurement.kind)},
                                     {"direction", measurement.direction}};
  if (measurement.kind == LabMeasurementKind::kTensile) document["length"] = measurement.length;
  if (measurement.width > 0.0) document["width"] = measurement.width;
  document["sigma"] = measurement.sigma;
  document["points"] = nlohmann::ordered_json::array();
  const Form form = MeasurementForm(measurement.kind);
  for (const LabPoint& point : measurement.points)
    document["points"].push_back({{form.set, point.set}, {form.reading, point.reading}});
  WriteFileAtomically(path, document.dump(2) + "\n");
}

}  // namespace drape
