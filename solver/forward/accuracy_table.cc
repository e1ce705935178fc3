// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/accuracy_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "solver/forward/settle.h"

namespace drape {
namespace {

constexpr char kAccuracyFormat[] = "drapefit-accuracy";
constexpr int kVersion = 2;

// Ranges of a table's numbers. Time step and steps are those of --time_step and --steps, though no
// drape is at rest after a shorter step.
constexpr double kMinTimeStep = 1e-4, kMaxTimeStep = 10.0;  // [s]
constexpr int kMaxSteps = 1000000;
constexpr double kMinError = 1e-6, kMaxError = 1e3;  // [mm]
constexpr double kMinCost = 1e-9, kMaxCost = 1e9;    // by that of the row "exact"

std::string Millimetres(double error) { return Format("%.3gmm", error); }

// "0.5mm" → 0.5.
double ParseLength(const std::string& text) {
  double length = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  const bool has_unit = std::string(end, text.data() + text.size()) == "mm";
  if (error != std::errc() || !has_unit || !(length > 0) || !std::isfinite(length))
    throw InputError("option 'accuracy'",
                     "found '" + text +
                         "', expected fast, balanced, exact or a length above 0 "
                         "such as 0.5mm");
  return length;
}

// "disc:1200": what the errors of a table are of.
std::string ReadMesh(const JsonInput& input) {
  constexpr std::string_view kDisc = "disc:";
  constexpr int kMinVertices = 100, kMaxVertices = 1000000;  // MakeDisc
  const std::string mesh = input.String();
  int vertices = 0;
  const char* const end = mesh.data() + mesh.size();
  const char* const number = std::min(mesh.data() + kDisc.size(), end);
  const auto [rest, error] = std::from_chars(number, end, vertices);
  if (!mesh.starts_with(kDisc) || error != std::errc() || rest != end || vertices < kMinVertices ||
      vertices > kMaxVertices)
    input.Fail(Format("disc:N with N from %d to %d", kMinVertices, kMaxVertices));
  return mesh;
}

double ReadError(const JsonInput& input) { return input.NumberWithin(kMinError, kMaxError); }

AccuracyRow ReadRow(const JsonInput& input) {
  input.ExpectKeys(
      {"mesh", "solve", "time_step", "steps", "error_mm", "residual", "drift_mm", "cost"});
  AccuracyRow row;
  row.mesh = ReadMesh(input.At("mesh"));
  row.integrator = input.At("solve").String();
  if (row.integrator != "dynamic" && row.integrator != "hybrid")
    input.At("solve").Fail("dynamic or hybrid");
  row.h = input.At("time_step").NumberWithin(kMinTimeStep, kMaxTimeStep);
  row.steps = input.At("steps").IntegerWithin(1, kMaxSteps);
  row.error_mm = ReadError(input.At("error_mm"));
  row.residual = input.At("residual").NumberWithin(0, kAtRestResidual);
  row.drift_mm = input.At("drift_mm").NumberWithin(0, 1e3 * kAtRestDrift);
  row.cost = input.At("cost").NumberWithin(kMinCost, kMaxCost);
  return row;
}

}  // namespace

const AccuracyRow& AccuracyTable::Pick(const std::string& accuracy,
                                       const std::string& integrator) const {
  const double wanted = accuracy == "fast"       ? fast
                        : accuracy == "balanced" ? balanced
                        : accuracy == "exact"    ? exact
                                                 : ParseLength(accuracy);
  const auto is_allowed = [&](const AccuracyRow& row) {
    return integrator.empty() || row.integrator == integrator;
  };
  if (std::none_of(rows.begin(), rows.end(), is_allowed))
    throw InputError("option 'accuracy'", "found solve = " + integrator + ", expected " +
                                              rows.front().integrator + ": the table has no " +
                                              integrator + " setting whose drapes are at rest");
  const AccuracyRow* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const AccuracyRow& row : rows) {
    if (!is_allowed(row)) continue;
    least = std::min(least, row.error_mm);
    if (row.error_mm <= wanted && (best == nullptr || row.cost < best->cost)) best = &row;
  }
  if (best == nullptr)
    throw InputError("option 'accuracy'", "found " + accuracy + ", expected at least " +
                                              Millimetres(least) +
                                              ": the table has nothing more exact");
  return *best;
}

AccuracyTable ParseAccuracyTable(const std::string& text, const std::string& where) {
  const nlohmann::json file = ParseJson(text, where);
  const JsonInput input(file, where);
  if (input.At("format").String() != kAccuracyFormat) input.At("format").Fail(kAccuracyFormat);
  if (input.At("version").Integer() != kVersion)
    input.At("version").Fail("2, a table of drapes at rest (make it again by drape_bench)");
  input.ExpectKeys({"format", "version", "made_on", "max_residual", "max_drift_mm", "fast_mm",
                    "balanced_mm", "exact_mm", "rows"});
  AccuracyTable table;
  table.made_on = input.At("made_on").String();
  input.At("max_residual").NumberWithin(0, kAtRestResidual);
  input.At("max_drift_mm").NumberWithin(0, 1e3 * kAtRestDrift);
  table.fast = ReadError(input.At("fast_mm"));
  table.balanced = ReadError(input.At("balanced_mm"));
  table.exact = ReadError(input.At("exact_mm"));
  const JsonInput rows = input.At("rows").ExpectArray();
  if (rows.Size() == 0) rows.Fail("at least one row");
  for (int i = 0; i < rows.Size(); ++i) table.rows.push_back(ReadRow(rows.At(i)));
  return table;
}

}  // namespace drape
