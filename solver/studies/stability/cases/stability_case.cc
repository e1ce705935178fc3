// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/cases/stability_case.h"

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
    case StabilityMethod::kPenalty:
      return "penalty";
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
    case StabilityOutcome::kHolds:
      return "holds";
    case StabilityOutcome::kPassedThrough:
      return "passed through";
    case StabilityOutcome::kCutsIn:
      return "cuts in";
    case StabilityOutcome::kOffTheLaw:
      return "off the law";
    case StabilityOutcome::kPinched:
      return "pinched";
  }
  return "unknown";
}

char StabilityLetter(StabilityOutcome outcome) {
  constexpr char kLetters[] = "SmbFDXNHTCLP";
  static_assert(sizeof(kLetters) == kStabilityOutcomes + 1);
  return kLetters[static_cast<int>(outcome)];
}

const char* ToString(StabilityScenario scenario) {
  constexpr const char* kNames[kStabilityScenarios] = {"drape",  "support", "ball", "plate", "rod",
                                                       "sheets", "slope",   "skid", "pinch"};
  return kNames[static_cast<int>(scenario)];
}

StabilityScenario ParseStabilityScenario(const std::string& name, const std::string& where) {
  return Parse<StabilityScenario>(kStabilityScenarios, name, where);
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
      {"thickness", "thickness of the cloth [m]", 1e-6, 0.01, {&Case::thickness}},
      {"range", "range of the barrier [m]", 1e-6, 0.01, {&Case::range}},
      {"edge", "edge length of the mesh [m]", 2e-3, 0.05, {&Case::edge}},
      {"speed", "speed [m/s]", 1e-3, 1000.0, {&Case::speed}},
      {"radius", "radius of the ball or rod [m]", 5e-4, 0.2, {&Case::radius}},
      {"friction", "friction coefficient", 0.0, 10.0, {&Case::friction}},
      {"creep_speed", "creep speed of friction [m/s]", 1e-6, 1.0, {&Case::creep_speed}},
      {"friction_rounds", "solves of a step for friction", 1.0, 100.0, {&Case::friction_rounds}},
      {"distance", "distance at which the balls stop [m]", 1e-5, 0.01, {&Case::distance}},
      {"layers", "layers of cloth", 1.0, 2.0, {&Case::layers}},
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

std::string StabilityInputs(const StabilityCase& run) {
  std::string text = std::string(ToString(run.method)) + ',' + run.law;
  for (const double value : {run.h, run.stretch, run.bend, run.density, run.sliver, run.compression,
                             run.tangle, run.handle, run.pre_steps})
    AppendNumber(text += ',', value);
  text += std::string(",") + ToString(run.scenario);
  for (const double value :
       {run.thickness, run.range, run.edge, run.speed, run.radius, run.friction, run.creep_speed,
        run.friction_rounds, run.distance, run.layers})
    AppendNumber(text += ',', value);
  return text;
}

}  // namespace drape
