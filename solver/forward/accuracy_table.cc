// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/accuracy_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr char kFormat[] = "drapefit-accuracy";

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

AccuracyRow ReadRow(const JsonInput& input) {
  input.ExpectKeys({"mesh", "solve", "time_step", "steps", "error_mm", "cost"});
  AccuracyRow row;
  row.mesh = input.At("mesh").String();
  row.integrator = input.At("solve").String();
  if (row.integrator != "dynamic" && row.integrator != "hybrid")
    input.At("solve").Fail("dynamic or hybrid");
  row.h = input.At("time_step").Number();
  row.steps = input.At("steps").Integer();
  row.error_mm = input.At("error_mm").Number();
  row.cost = input.At("cost").Number();
  for (const char* key : {"time_step", "steps", "error_mm", "cost"})
    if (!(input.At(key).Number() > 0)) input.At(key).Fail("a number above 0");
  return row;
}

}  // namespace

const AccuracyRow& AccuracyTable::Pick(const std::string& accuracy,
                                       const std::string& integrator) const {
  const double wanted = accuracy == "fast"       ? fast
                        : accuracy == "balanced" ? balanced
                        : accuracy == "exact"    ? exact
                                                 : ParseLength(accuracy);
  const AccuracyRow* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const AccuracyRow& row : rows) {
    if (!integrator.empty() && row.integrator != integrator) continue;
    least = std::min(least, row.error_mm);
    if (row.error_mm <= wanted && (best == nullptr || row.cost < best->cost)) best = &row;
  }
  if (best == nullptr)
    throw InputError("option 'accuracy'", "found " + accuracy + ", expected at least " +
                                              Millimetres(least) +
                                              ": the table has nothing more exact");
  return *best;
}

std::string AccuracyTableText(const AccuracyTable& table) {
  nlohmann::ordered_json json = {{"format", kFormat},
                                 {"version", 1},
                                 {"made_on", table.made_on},
                                 {"fast_mm", table.fast},
                                 {"balanced_mm", table.balanced},
                                 {"exact_mm", table.exact}};
  for (const AccuracyRow& row : table.rows)
    json["rows"].push_back({{"mesh", row.mesh},
                            {"solve", row.integrator},
                            {"time_step", row.h},
                            {"steps", row.steps},
                            {"error_mm", row.error_mm},
                            {"cost", row.cost}});
  return json.dump(2) + "\n";
}

AccuracyTable ParseAccuracyTable(const std::string& text, const std::string& where) {
  const nlohmann::json file = ParseJson(text, where);
  const JsonInput input(file, where);
  input.ExpectKeys({"format", "version", "made_on", "fast_mm", "balanced_mm", "exact_mm", "rows"});
  if (input.At("format").String() != kFormat) input.At("format").Fail(kFormat);
  if (input.At("version").Integer() != 1) input.At("version").Fail("1");
  AccuracyTable table;
  table.made_on = input.At("made_on").String();
  table.fast = input.At("fast_mm").Number();
  table.balanced = input.At("balanced_mm").Number();
  table.exact = input.At("exact_mm").Number();
  const JsonInput rows = input.At("rows").ExpectArray();
  if (rows.Size() == 0) rows.Fail("at least one row");
  for (int i = 0; i < rows.Size(); ++i) table.rows.push_back(ReadRow(rows.At(i)));
  return table;
}

}  // namespace drape
