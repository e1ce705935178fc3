// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/cases/stability_case.h"

#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {

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
      {"thickness", "thickness of the cloth [m]", 1e-6, 0.01, {&Case::thickness}},
      {"range", "range of the barrier [m]", 1e-6, 0.01, {&Case::range}},
  };
  return axes;
}

const StabilityAxis& FindStabilityAxis(const std::string& name, const std::string& where) {
  std::string names;
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (name == axis.name) return axis;
    names += std::string(names.empty() ? "" : ", ") + axis.name;
  }
  throw InputError(where, "found '" + name + "', expected one of " + names + ", law, scenario");
}

std::string CaseName(const StabilityCase& run) {
  const StabilityCase usual;
  std::string name = ToString(run.method);
  if (run.law != usual.law) name += std::string(" law=") + ToString(run.law);
  if (run.scenario != usual.scenario) name += std::string(" scenario=") + ToString(run.scenario);
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (axis.fields.size() > 1 || run.*axis.fields[0] == usual.*axis.fields[0]) continue;
    AppendNumber(name += std::string(" ") + axis.name + "=", run.*axis.fields[0]);
  }
  return name;
}

nlohmann::json CaseJson(const StabilityCase& run) {
  nlohmann::json json = {{"method", ToString(run.method)},
                         {"law", ToString(run.law)},
                         {"scenario", ToString(run.scenario)}};
  for (const StabilityAxis& axis : StabilityAxes())
    if (axis.fields.size() == 1) json[axis.name] = run.*axis.fields[0];
  return json;
}

}  // namespace drape
