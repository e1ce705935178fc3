// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/bench_plan.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "solver/studies/runner/study.h"

namespace drape {
namespace {

using nlohmann::ordered_json;

// One thread runs the drapes of a batch one after the other.
bool RunsBatches(const BenchSetting& setting) {
  return setting.backend != "cpu" || setting.threads > 1;
}

// Each run with each value of an axis, or with the first one where it does not have the axis.
template <class Value>
void Multiply(const std::vector<Value>& values, Value BenchSetting::*member,
              std::vector<BenchSetting>* runs,
              const std::function<bool(const BenchSetting&)>& has_axis = nullptr) {
  std::vector<BenchSetting> product;
  for (const BenchSetting& run : *runs)
    for (const Value& value : values) {
      product.push_back(run);
      product.back().*member = value;
      if (has_axis && !has_axis(run)) break;
    }
  *runs = std::move(product);
}

}  // namespace

int BenchSetting::steps() const {
  return std::max(1, static_cast<int>(std::lround(relax_time / h)));
}

ordered_json ListAxes(const BenchSetting& setting) {
  ordered_json axes = {{"material", MaterialLabel(setting.material)},
                       {"law", setting.law},
                       {"model", setting.model}};
  if (IsDistribution(setting)) axes["draws"] = setting.draws;
  axes.update({{"mesh", NameWithoutFolder(setting.mesh)},
               {"solve", setting.integrator},
               {"time_step", setting.h},
               {"relax_time", setting.relax_time},
               {"tolerance", setting.tolerance},
               {"mode", setting.mode},
               {"backend", setting.backend},
               {"threads", setting.threads}});
  if (RunsBatches(setting)) axes["batch"] = setting.batch;
  return axes;
}

std::string RunName(BenchWork work, const BenchSetting& setting) {
  const ordered_json axes = ListAxes(setting), defaults = ListAxes(BenchSetting());
  std::string name = ToString(work);
  for (const auto& [axis, value] : axes.items())
    if (!defaults.contains(axis) || defaults.at(axis) != value)
      name += " " + axis + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
  return name;
}

bool IsDistribution(const BenchSetting& setting) {
  return setting.model == "bdp" || setting.model == "bayes";
}

std::vector<BenchSetting> ListRuns(BenchWork work, const BenchAxes& axes) {
  std::vector<BenchSetting> runs(1);
  Multiply(axes.material, &BenchSetting::material, &runs);
  Multiply(axes.law, &BenchSetting::law, &runs);
  Multiply(axes.model, &BenchSetting::model, &runs);
  Multiply(axes.draws, &BenchSetting::draws, &runs, IsDistribution);
  Multiply(axes.mesh, &BenchSetting::mesh, &runs);
  Multiply(axes.integrator, &BenchSetting::integrator, &runs);
  Multiply(axes.h, &BenchSetting::h, &runs);
  Multiply(axes.relax_time, &BenchSetting::relax_time, &runs);
  Multiply(axes.tolerance, &BenchSetting::tolerance, &runs);
  if (work == BenchWork::kGradient || work == BenchWork::kJacobian)
    Multiply(axes.mode, &BenchSetting::mode, &runs);
  Multiply(axes.backend, &BenchSetting::backend, &runs);
  Multiply(axes.threads, &BenchSetting::threads, &runs);
  Multiply(axes.batch, &BenchSetting::batch, &runs, RunsBatches);
  std::set<std::string> names;
  for (const BenchSetting& run : runs)
    if (const std::string name = RunName(work, run); !names.insert(name).second)
      throw InputError("axes", "found two runs '" + name +
                                   "', expected different values of each axis, and materials and "
                                   "meshes whose files have different names");
  return runs;
}

}  // namespace drape
