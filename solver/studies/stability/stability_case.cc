// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_case.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

const StabilityAxis& FindAxis(const std::string& name, const std::string& where) {
  std::string names;
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (name == axis.name) return axis;
    names += std::string(axis.name) + ", ";
  }
  throw InputError(where, "found '" + name + "', expected one of " + names + "law");
}

std::vector<std::string> SplitAt(const std::string& text, char by) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, by);) parts.push_back(part);
  return parts;
}

template <class T>
T ParseNumber(const std::string& text, T least, T most, const char* what,
              const std::string& where) {
  T value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && value >= least && value <= most) return value;
  std::string range;
  AppendNumber(range, least);
  AppendNumber(range += " … ", most);
  throw InputError(where, "found '" + text + "', expected a " + what + ", " + range);
}

// Four digits are enough of a value in a list that people read.
double Rounded(double value) { return std::stod(Format("%.4g", value)); }

std::vector<double> ParseValues(const std::string& text, const StabilityAxis& axis,
                                const std::string& where) {
  const auto parse = [&](const std::string& part) {
    return ParseNumber(part, axis.least, axis.most, "number", where);
  };
  std::vector<double> values;
  if (const std::vector<std::string> range = SplitAt(text, ':'); range.size() == 3) {
    const double from = parse(range[0]), to = parse(range[1]);
    const int count = ParseNumber(range[2], 2, 200, "count", where);
    if (!(from > 0.0 && to > from))
      throw InputError(where, "expected from:to:count with 0 < from < to");
    for (int i = 0; i < count; ++i)
      values.push_back(Rounded(from * std::pow(to / from, i / (count - 1.0))));
    return values;
  }
  for (const std::string& part : SplitAt(text, '/')) values.push_back(parse(part));
  if (values.empty()) throw InputError(where, "has no value");
  std::sort(values.begin(), values.end());
  if (std::adjacent_find(values.begin(), values.end()) != values.end())
    throw InputError(where, "holds a value twice");
  return values;
}

void ParseSetting(const std::string& text, const std::string& where, StabilityMap& map) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw InputError(where, "found '" + text + "', expected axis=values");
  const std::string name = text.substr(0, equals), value = text.substr(equals + 1);
  if (name == "law") {
    map.base.law = ParseName<LawKind>(value, where);
    map.name += "-" + value;
    return;
  }
  const StabilityAxis& axis = FindAxis(name, where);
  const std::vector<double> values = ParseValues(value, axis, where + ": " + name);
  if (values.size() == 1) {
    axis.Set(map.base, values[0]);
    map.name += "-" + name + value;
    return;
  }
  const int k = map.axis[0] == nullptr ? 0 : 1;
  if (map.axis[k] != nullptr) throw InputError(where, "found a third axis, '" + name + "'");
  map.axis[k] = &axis;
  map.values[k] = values;
}

}  // namespace

std::span<const StabilityAxis> StabilityAxes() {
  using Case = StabilityCase;
  static const std::vector<StabilityAxis> axes = {
      {"time_step", "time step h [s]", 1e-6, 10.0, {&Case::h}},
      {"stiffness",
       "stiffness, stretch and bend [factor]",
       1e-6,
       1e6,
       {&Case::stretch, &Case::bend}},
      {"stretch", "stretch stiffness [factor]", 1e-6, 1e6, {&Case::stretch}},
      {"bend", "bend stiffness [factor]", 1e-6, 1e6, {&Case::bend}},
      {"density", "density [kg/m²]", 1e-4, 10.0, {&Case::density}},
      {"sliver", "needles, long by short side", 1.0, 1e6, {&Case::sliver}},
      {"compression", "size of the start in the plane [factor]", 0.1, 2.0, {&Case::compression}},
      {"tangle", "random displacement of the start [edge lengths]", 0.0, 10.0, {&Case::tangle}},
      {"handle", "handle stiffness [factor]", 1e-6, 1e6, {&Case::handle}},
      {"pre_steps", "steps before Newton", 0.0, 10000.0, {&Case::pre_steps}},
  };
  return axes;
}

std::string CaseName(const StabilityCase& run) {
  const StabilityCase usual;
  std::string name = ToString(run.method);
  if (run.law != usual.law) name += std::string(" law=") + ToString(run.law);
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (axis.fields.size() > 1 || run.*axis.fields[0] == usual.*axis.fields[0]) continue;
    AppendNumber(name += std::string(" ") + axis.name + "=", run.*axis.fields[0]);
  }
  return name;
}

nlohmann::json CaseJson(const StabilityCase& run) {
  nlohmann::json json = {{"method", ToString(run.method)}, {"law", ToString(run.law)}};
  for (const StabilityAxis& axis : StabilityAxes())
    if (axis.fields.size() == 1) json[axis.name] = run.*axis.fields[0];
  return json;
}

StabilityCase StabilityMap::At(int i, int j) const {
  StabilityCase run = base;
  axis[0]->Set(run, values[0][i]);
  axis[1]->Set(run, values[1][j]);
  return run;
}

std::vector<StabilityCase> StabilityMap::Cases() const {
  std::vector<StabilityCase> cases;
  for (int j = 0; j < static_cast<int>(values[1].size()); ++j)
    for (int i = 0; i < static_cast<int>(values[0].size()); ++i) cases.push_back(At(i, j));
  return cases;
}

std::vector<StabilityMap> ParseStabilityMaps(const std::string& line, const std::string& where) {
  const std::string place = where + " '" + line + "'";
  std::istringstream words(line);
  std::string methods;
  words >> methods;
  StabilityMap map;
  for (std::string word; words >> word;) ParseSetting(word, place, map);
  if (map.axis[1] == nullptr)
    throw InputError(place, "expected two axes with more than one value each");
  if (map.axis[0] == map.axis[1])
    throw InputError(place, std::string("names '") + map.axis[0]->name + "' twice");
  std::vector<StabilityMap> maps;
  for (const std::string& method : SplitAt(methods, '+')) {
    maps.push_back(map);
    maps.back().base.method = ParseName<StabilityMethod>(method, place);
    maps.back().name = method + "-" + map.axis[0]->name + "-" + map.axis[1]->name + map.name;
  }
  return maps;
}

}  // namespace drape
