// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "physics/material/laws/law_kind.h"

namespace drape {

// One run of the stability atlas: how a drape is solved, and which of its inputs are unusual.

enum class StabilityMethod {
  kExplicit,         // symplectic Euler with the drag of air
  kStep,             // the one-solve step [MODEL, M30], factored
  kStepPcg,          // the same, conjugate gradients
  kStepFloat,        // the same in single precision
  kImplicit,         // implicit Euler, converged
  kStatic,           // SolveEquilibrium as drapes use it
  kStaticMassShift,  // with a shift by the mass alone
  kStaticNoShift,    // without a shift
  kStaticProjected   // with each element's stiffness projected
};
constexpr auto EnumNames(StabilityMethod) {
  using Method = StabilityMethod;
  return MakeNames<Method>({{Method::kExplicit, "explicit"},
                            {Method::kStep, "step"},
                            {Method::kStepPcg, "step_pcg"},
                            {Method::kStepFloat, "step_float"},
                            {Method::kImplicit, "implicit"},
                            {Method::kStatic, "static"},
                            {Method::kStaticMassShift, "static_mass_shift"},
                            {Method::kStaticNoShift, "static_no_shift"},
                            {Method::kStaticProjected, "static_projected"}});
}
inline bool IsStatic(StabilityMethod method) { return method >= StabilityMethod::kStatic; }

// How a run ended, by StabilityRules.
enum class StabilityOutcome {
  kSettled,
  kStillMoving,
  kOtherBranch,
  kFoldedOver,
  kDiverged,
  kFactorFailed,
  kNotConverged
};
constexpr auto EnumNames(StabilityOutcome) {
  using Outcome = StabilityOutcome;
  return MakeNames<Outcome>({{Outcome::kSettled, "settled"},
                             {Outcome::kStillMoving, "still moving"},
                             {Outcome::kOtherBranch, "other branch"},
                             {Outcome::kFoldedOver, "folded over"},
                             {Outcome::kDiverged, "diverged"},
                             {Outcome::kFactorFailed, "factor failed"},
                             {Outcome::kNotConverged, "not converged"}});
}

enum class StabilityScenario {
  kDrape,   // the drape test
  kSupport  // the same, with contact of the hanging part with its support
};
constexpr auto EnumNames(StabilityScenario) {
  return MakeNames<StabilityScenario>(
      {{StabilityScenario::kDrape, "drape"}, {StabilityScenario::kSupport, "support"}});
}

struct StabilityCase {
  StabilityMethod method = StabilityMethod::kStep;
  LawKind law = LawKind::kSmooth;
  double h = 0.05;       // time step [s]; of a static method, the step of its steps before
  double stretch = 1.0;  // factors of all entries
  double bend = 1.0;
  double density = 0.2;  // [kg/m²]
  double sliver = 1.0;   // long by short side of needles among the triangles (AddSliverTriangles)
  double compression = 1.0;  // of the start in the plane
  double tangle = 0.0;       // random displacement of free vertices by axis [mean edges]
  double handle = 1.0;       // factor of the handles' stiffness
  double pre_steps = 20.0;   // one-solve steps before a static method, whole
  StabilityScenario scenario = StabilityScenario::kDrape;
  double thickness = 4e-4;  // of the cloth in contact [m]
  double range = 5e-4;      // of the gap in which surfaces push one another [m]

  bool operator==(const StabilityCase&) const = default;
};

// What a map can have as an axis.
struct StabilityAxis {
  const char* name;   // in a config
  const char* label;  // in a chart, with the unit
  double least, most;
  std::vector<double StabilityCase::*> fields;  // all set alike

  void Set(StabilityCase& run, double value) const {
    for (double StabilityCase::*field : fields) run.*field = value;
  }
};
std::span<const StabilityAxis> StabilityAxes();
// Throws InputError that starts with `where` and lists the names.
const StabilityAxis& FindStabilityAxis(const std::string& name, const std::string& where);

// "step time_step=0.1 tangle=0.2": the method and whatever is unusual. Equal names are equal cases.
std::string CaseName(const StabilityCase& run);
// All members by the names of their axes.
nlohmann::json CaseJson(const StabilityCase& run);

}  // namespace drape
