// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/cases/stability_map.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kMostValues = 200;

std::vector<std::string> Split(const std::string& text, char by) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, by);) parts.push_back(part);
  return parts;
}

double ParseValue(const std::string& text, const StabilityAxis& axis, const std::string& where) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && value >= axis.least && value <= axis.most) return value;
  std::string range;
  AppendNumber(range, axis.least);
  AppendNumber(range += " … ", axis.most);
  throw InputError(where, "found '" + text + "', expected a number, " + range);
}

int ParseCount(const std::string& text, const std::string& where) {
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (whole && count >= 2 && count <= kMostValues) return count;
  throw InputError(where,
                   "found '" + text + "', expected a count, 2 … " + std::to_string(kMostValues));
}

// Four digits are enough of a value in a list that people read.
double Rounded(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g", value);
  std::from_chars(digits, digits + sizeof digits, value);
  return value;
}

std::vector<double> EvenlyByRatio(double from, double to, int count, const std::string& where) {
  if (!(from > 0.0 && to > from))
    throw InputError(where, "expected from:to:count with 0 < from < to");
  std::vector<double> values;
  for (int i = 0; i < count; ++i)
    values.push_back(Rounded(from * std::pow(to / from, i / (count - 1.0))));
  return values;
}

std::vector<double> ParseValues(const std::string& text, const StabilityAxis& axis,
                                const std::string& where) {
  if (const std::vector<std::string> range = Split(text, ':'); range.size() == 3)
    return EvenlyByRatio(ParseValue(range[0], axis, where), ParseValue(range[1], axis, where),
                         ParseCount(range[2], where), where);
  std::vector<double> values;
  for (const std::string& part : Split(text, '/')) values.push_back(ParseValue(part, axis, where));
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
  if (name == "scenario") {
    map.base.scenario = ParseName<StabilityScenario>(value, where);
    map.name += "-" + value;
    return;
  }
  const StabilityAxis& axis = FindStabilityAxis(name, where);
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
  for (const std::string& method : Split(methods, '+')) {
    maps.push_back(map);
    maps.back().base.method = ParseName<StabilityMethod>(method, place);
    maps.back().name = method + "-" + map.axis[0]->name + "-" + map.axis[1]->name + map.name;
  }
  return maps;
}

}  // namespace drape
