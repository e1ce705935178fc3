// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/validation/validation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/simulation/statics/statics.h"
#include "physics/util/errors.h"
#include "solver/studies/validation/validation_groups.h"

namespace drape {
namespace {

using Group = std::pair<std::string, std::vector<ReferenceCase> (*)(const Law&)>;

const std::vector<Group>& Groups() {
  static const std::vector<Group> groups = {
      {"rigidity", [](const Law&) { return RigidityCases(); }},
      {"cantilever", CantileverCases},
      {"tip_load", TipLoadCases},
      {"hanging", HangingCases},
      {"uniaxial", UniaxialCases},
      {"disc", ClampedDiscCases},
      {"annulus", AnnulusCases},
      {"rigid", RigidMotionCases},
      {"turn", TurnCases}};
  return groups;
}

std::vector<Group> Chosen(const std::vector<std::string>& only) {
  if (only.empty()) return Groups();
  std::vector<Group> chosen;
  for (const std::string& name : only) {
    const auto found = std::find_if(Groups().begin(), Groups().end(),
                                    [&](const Group& group) { return group.first == name; });
    if (found == Groups().end()) {
      std::string allowed;
      for (const Group& group : Groups()) allowed += (allowed.empty() ? "" : ", ") + group.first;
      throw InputError("filter", "unknown group \"" + name + "\", expected one of " + allowed);
    }
    chosen.push_back(*found);
  }
  return chosen;
}

}  // namespace

ReferenceCase RelativeReference(std::string group, std::string name, double expected,
                                double tolerance) {
  return {.group = std::move(group),
          .name = std::move(name),
          .expected = expected,
          .tolerance = tolerance,
          .computed = {},
          .scale = std::abs(expected)};
}

void GoToRest(StepSolver& solver, const MaterialField& material, Eigen::VectorXd& x) {
  EquilibriumOptions options;
  options.tolerance = 1e-6;  // rounding of stiff hinges on triangles of 0.3 mm is 1e-7
  const EquilibriumResult rest = SolveEquilibrium(solver, material, x, options);
  x = rest.x;
  if (rest.status == EquilibriumStatus::kNotConverged)
    x.setConstant(std::numeric_limits<double>::quiet_NaN());
}

std::vector<std::string> ValidationGroups() {
  std::vector<std::string> names;
  for (const Group& group : Groups()) names.push_back(group.first);
  return names;
}

std::vector<ReferenceCase> Validate(const ValidationOptions& options, const RunControl& control) {
  const Law law = MakeLaw(options.law);
  const std::vector<Group> groups = Chosen(options.only);
  std::vector<ReferenceCase> cases;
  double done = 0.0;
  for (const auto& [name, measure] : groups) {
    if (control.cancelled()) break;
    for (ReferenceCase& one : measure(law)) cases.push_back(std::move(one));
    control.Report(++done / static_cast<double>(groups.size()), name);
  }
  return cases;
}

bool AllPass(const std::vector<ReferenceCase>& cases) {
  return std::all_of(cases.begin(), cases.end(), [](const ReferenceCase& t) { return t.Holds(); });
}

}  // namespace drape
