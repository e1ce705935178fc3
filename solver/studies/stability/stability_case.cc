// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_case.h"

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

template <class Kind>
Kind Parse(int count, const std::string& name, const std::string& where) {
  std::string names;
  for (int i = 0; i < count; ++i) {
    const char* each = ToString(static_cast<Kind>(i));
    if (name == each) return static_cast<Kind>(i);
    names += std::string(i == 0 ? "" : ", ") + each;
  }
  throw InputError(where, "found '" + name + "', expected one of " + names);
}

}  // namespace

const char* ToString(StabilityMethod method) {
  switch (method) {
    case StabilityMethod::kExplicit:
      return "explicit";
    case StabilityMethod::kStep:
      return "step";
    case StabilityMethod::kStepPcg:
      return "step_pcg";
    case StabilityMethod::kStepFloat:
      return "step_float";
    case StabilityMethod::kImplicit:
      return "implicit";
    case StabilityMethod::kStatic:
      return "static";
    case StabilityMethod::kStaticMassShift:
      return "static_mass_shift";
    case StabilityMethod::kStaticNoShift:
      return "static_no_shift";
    case StabilityMethod::kStaticProjected:
      return "static_projected";
  }
  return "unknown";
}

const char* ToString(StabilityOutcome outcome) {
  switch (outcome) {
    case StabilityOutcome::kSettled:
      return "settled";
    case StabilityOutcome::kStillMoving:
      return "still moving";
    case StabilityOutcome::kOtherBranch:
      return "other branch";
    case StabilityOutcome::kFoldedOver:
      return "folded over";
    case StabilityOutcome::kDiverged:
      return "diverged";
    case StabilityOutcome::kFactorFailed:
      return "factor failed";
    case StabilityOutcome::kNotConverged:
      return "not converged";
  }
  return "unknown";
}

char StabilityLetter(StabilityOutcome outcome) {
  constexpr char kLetters[] = "SmbFDXN";
  static_assert(sizeof(kLetters) == kStabilityOutcomes + 1);
  return kLetters[static_cast<int>(outcome)];
}

StabilityMethod ParseStabilityMethod(const std::string& name, const std::string& where) {
  return Parse<StabilityMethod>(kStabilityMethods, name, where);
}
StabilityOutcome ParseStabilityOutcome(const std::string& name, const std::string& where) {
  return Parse<StabilityOutcome>(kStabilityOutcomes, name, where);
}

bool IsStatic(StabilityMethod method) { return method >= StabilityMethod::kStatic; }

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

const StabilityAxis& FindStabilityAxis(const std::string& name, const std::string& where) {
  std::string names;
  for (const StabilityAxis& axis : StabilityAxes()) {
    if (name == axis.name) return axis;
    names += std::string(names.empty() ? "" : ", ") + axis.name;
  }
  throw InputError(where, "found '" + name + "', expected one of " + names + ", law");
}

std::string StabilityInputs(const StabilityCase& run) {
  std::string text = std::string(ToString(run.method)) + ',' + run.law;
  for (const double value : {run.h, run.stretch, run.bend, run.density, run.sliver, run.compression,
                             run.tangle, run.handle, run.pre_steps})
    AppendNumber(text += ',', value);
  return text;
}

}  // namespace drape
