// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_plan.h"

#include <algorithm>
#include <cmath>

#include "physics/material/material_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr BenchWork kWorks[] = {BenchWork::kForward, BenchWork::kGradient, BenchWork::kJacobian,
                                BenchWork::kFit};

std::string Text(double value) {
  std::string text;
  AppendNumber(text, value);
  return text;
}
std::string Text(int value) { return std::to_string(value); }
std::string Text(const std::string& value) { return value; }

// Calls visit(name, values, member) for each axis.
template <class Axes, class Visit>
void VisitAxes(Axes& axes, const Visit& visit) {
  visit("material", axes.material, &BenchSetting::material);
  visit("law", axes.law, &BenchSetting::law);
  visit("model", axes.model, &BenchSetting::model);
  visit("draws", axes.draws, &BenchSetting::draws);
  visit("mesh", axes.mesh, &BenchSetting::mesh);
  visit("solve", axes.integrator, &BenchSetting::integrator);
  visit("time_step", axes.h, &BenchSetting::h);
  visit("relax_time", axes.relax_time, &BenchSetting::relax_time);
  visit("tolerance", axes.tolerance, &BenchSetting::tolerance);
  visit("mode", axes.mode, &BenchSetting::mode);
  visit("backend", axes.backend, &BenchSetting::backend);
  visit("threads", axes.threads, &BenchSetting::threads);
  visit("batch", axes.batch, &BenchSetting::batch);
}

const std::vector<std::string>* FindChoices(const std::string& axis) {
  static const std::vector<std::pair<std::string, std::vector<std::string>>> choices = {
      {"law", {"reference", "smooth"}},
      {"model", {"homogeneous", "heterogeneous_modes", "heterogeneous_elements", "bdp", "bayes"}},
      {"solve", {"dynamic", "hybrid", "static"}},
      {"mode", {"adjoint", "tangent"}},
      {"backend", {"auto", "cpu", "cuda"}}};
  for (const auto& [name, values] : choices)
    if (name == axis) return &values;
  return nullptr;
}

[[noreturn]] void Fail(const std::string& axis, const std::string& found,
                       const std::string& expected) {
  throw InputError("axis '" + axis + "'", "found " + found + ", expected " + expected);
}

void CheckValue(const std::string& axis, const std::string& value) {
  const std::vector<std::string>* choices = FindChoices(axis);
  if (choices == nullptr || std::count(choices->begin(), choices->end(), value) > 0) return;
  std::string all;
  for (const std::string& choice : *choices) all += (all.empty() ? "" : ", ") + choice;
  Fail(axis, "'" + value + "'", "one of " + all);
}
void CheckValue(const std::string& axis, double value) {
  if (!(value > 0) || !std::isfinite(value)) Fail(axis, Text(value), "a number above 0");
}
void CheckValue(const std::string& axis, int value) {
  if (value < 1) Fail(axis, Text(value), "a whole number from 1 on");
}

template <class Value>
void CheckAxis(const std::string& axis, const std::vector<Value>& values) {
  if (values.empty()) Fail(axis, "no value", "at least one");
  for (std::size_t i = 0; i < values.size(); ++i) {
    CheckValue(axis, values[i]);
    if (std::count(values.begin(), values.begin() + i, values[i]) > 0)
      Fail(axis, Text(values[i]) + " twice", "different values");
  }
}

// One thread runs the drapes of a batch one after the other.
bool RunsBatches(const BenchSetting& setting) {
  return setting.backend != "cpu" || setting.threads > 1;
}

bool HasAxis(const BenchSetting& setting, const std::string& name) {
  return name == "draws" ? IsDistribution(setting) : name == "batch" ? RunsBatches(setting) : true;
}

}  // namespace

BenchWork ParseBenchWork(const std::string& text) {
  for (const BenchWork work : kWorks)
    if (text == ToString(work)) return work;
  throw InputError("option 'work'",
                   "found '" + text + "', expected forward, gradient, jacobian or fit");
}

const char* ToString(BenchWork work) {
  switch (work) {
    case BenchWork::kForward:
      return "forward";
    case BenchWork::kGradient:
      return "gradient";
    case BenchWork::kJacobian:
      return "jacobian";
    case BenchWork::kFit:
      return "fit";
  }
  return "unknown";
}

int BenchSetting::steps() const {
  return std::max(1, static_cast<int>(std::lround(relax_time / h)));
}

std::vector<std::pair<std::string, std::string>> ListAxes(const BenchSetting& setting) {
  std::vector<std::pair<std::string, std::string>> named;
  const BenchAxes names;
  VisitAxes(names, [&](const char* name, const auto&, auto member) {
    named.emplace_back(name, Text(setting.*member));
  });
  named[0].second = MaterialLabel(setting.material);
  return named;
}

std::string CheckpointKey(BenchWork work, const BenchSetting& setting) {
  std::string identity = ToString(work);
  for (const auto& [name, value] : ListAxes(setting)) identity += " " + name + "=" + value;
  return identity;
}

bool IsDistribution(const BenchSetting& setting) {
  return setting.model == "bdp" || setting.model == "bayes";
}

std::string MakeLabel(const BenchSetting& setting, const BenchAxes& varied) {
  std::string label;
  const auto named = ListAxes(setting);
  std::size_t at = 0;
  VisitAxes(varied, [&](const std::string& name, const auto& values, auto) {
    const std::string& value = named[at++].second;
    if (values.size() < 2 || !HasAxis(setting, name)) return;
    const bool is_word = FindChoices(name) != nullptr || name == "mesh" || name == "material";
    label += (label.empty() ? "" : " ") + (is_word ? value : name + "=" + value);
  });
  return label;
}

std::string MethodName(const BenchSetting& setting, const BenchAxes& axes) {
  BenchAxes methods;
  methods.model = axes.model;
  methods.integrator = axes.integrator;
  methods.mode = axes.mode;
  methods.backend = axes.backend;
  const std::string label = MakeLabel(setting, methods);
  return label.empty() ? setting.integrator : label;
}

std::vector<BenchSetting> ListRuns(BenchWork work, const BenchAxes& axes) {
  std::vector<BenchSetting> settings(1);
  VisitAxes(axes, [&](const std::string& name, const auto& values, auto member) {
    CheckAxis(name, values);
    const bool derives = work == BenchWork::kGradient || work == BenchWork::kJacobian;
    std::vector<BenchSetting> product;
    for (const BenchSetting& setting : settings) {
      const bool counts = name == "mode" ? derives : HasAxis(setting, name);
      for (const auto& value : values) {
        product.push_back(setting);
        product.back().*member = value;
        if (!counts) break;
      }
    }
    settings = std::move(product);
  });
  return settings;
}

}  // namespace drape
