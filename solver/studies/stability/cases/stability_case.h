// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace drape {

// One run of the stability atlas: how a drape is solved, and which of its inputs are unusual.

enum class StabilityMethod {
  kExplicit,         // symplectic Euler with the drag of air
  kStep,             // the one-solve step [MODEL, M30], factored
  kStepPcg,          // the same, conjugate gradients
  kStepFloat,        // the same in single precision
  kImplicit,         // implicit Euler, converged
  kPenalty,          // the one-solve step, and springs that push vertices out of obstacles
  kStatic,           // SolveEquilibrium as drapes use it
  kStaticMassShift,  // with a shift by the mass alone
  kStaticNoShift,    // without a shift
  kStaticProjected   // with each element's stiffness projected
};
inline constexpr int kStabilityMethods = 10;

// How a run ended, by StabilityRules.
enum class StabilityOutcome {
  kSettled,
  kStillMoving,
  kOtherBranch,
  kFoldedOver,
  kDiverged,
  kFactorFailed,
  kNotConverged,
  kHolds,          // from here on of contact: as it should be
  kPassedThrough,  // an obstacle, or the other sheet
  kCutsIn,         // a face reaches into an obstacle that its vertices are out of
  kOffTheLaw,      // of friction
  kPinched         // no place was left for the cloth
};
inline constexpr int kStabilityOutcomes = 12;

// As configs, files and legends have them: "step_pcg", "folded over". Parsing throws InputError
// that starts with `where` and lists the names.
const char* ToString(StabilityMethod method);
const char* ToString(StabilityOutcome outcome);
char StabilityLetter(StabilityOutcome outcome);  // in tables and charts
StabilityMethod ParseStabilityMethod(const std::string& name, const std::string& where);
StabilityOutcome ParseStabilityOutcome(const std::string& name, const std::string& where);
bool IsStatic(StabilityMethod method);

// What happens to the cloth.
enum class StabilityScenario {
  kDrape,    // the drape test
  kSupport,  // the same, with contact of the hanging part with its support
  // The others are of contact (contact/contact_scene.h).
  kBall,    // a square thrown on a ball,
  kPlate,   // on a thin plate,
  kRod,     // on a rod
  kSheets,  // two squares thrown at one another
  kSlope,   // a square on a slope of tan = .5
  kSkid,    // a square thrown askew on a floor
  kPinch    // squares between two balls that close
};
inline constexpr int kStabilityScenarios = 9;
const char* ToString(StabilityScenario scenario);
StabilityScenario ParseStabilityScenario(const std::string& name, const std::string& where);
inline bool IsOfContact(StabilityScenario scenario) {
  return scenario > StabilityScenario::kSupport;
}

struct StabilityCase {
  StabilityMethod method = StabilityMethod::kStep;
  std::string law = "smooth";
  double h = 0.05;       // time step [s]; of a static method, that of its steps before
  double stretch = 1.0;  // factors of all entries
  double bend = 1.0;
  double density = 0.2;  // [kg/m²]
  double sliver = 1.0;   // long by short side of needles among the triangles (AddSliverTriangles)
  double compression = 1.0;  // of the start in the plane
  double tangle = 0.0;       // random displacement of free vertices by axis [mean edges]
  double handle = 1.0;       // factor of the handles' stiffness
  double pre_steps = 20.0;   // one-solve steps before a static method, whole
  StabilityScenario scenario = StabilityScenario::kDrape;
  // Of all scenarios but the drape, in contact.
  double thickness = 4e-4;  // of the cloth [m]
  double range = 5e-4;      // of the gap in which surfaces push one another [m]
  // Of scenarios of contact.
  double edge = 0.01;          // of the mesh [m]
  double speed = 1.0;          // at which things are thrown or close [m/s]
  double radius = 0.05;        // of the ball or rod [m]
  double friction = 0.0;       // μ
  double creep_speed = 1e-3;   // [m/s], ImplicitEulerOptions
  double friction_rounds = 5;  // whole, ImplicitEulerOptions
  double distance = 1e-3;      // at which two balls stop [m]
  double layers = 1;           // between them, whole

  bool operator==(const StabilityCase&) const = default;
};

// What a map can have as an axis.
struct StabilityAxis {
  const char* name;   // in a config
  const char* label;  // of a plot, with the unit
  double least, most;
  std::vector<double StabilityCase::*> fields;  // all set alike

  void Set(StabilityCase& run, double value) const {
    for (double StabilityCase::*field : fields) run.*field = value;
  }
};
std::span<const StabilityAxis> StabilityAxes();
// Throws InputError that starts with `where` and lists the names.
const StabilityAxis& FindStabilityAxis(const std::string& name, const std::string& where);

// The inputs as fields of a CSV row, and the names of the columns. Equal rows are equal cases.
std::string StabilityInputs(const StabilityCase& run);
inline constexpr char kStabilityInputColumns[] =
    "method,law,h_s,stretch,bend,density_kg_m2,sliver,compression,tangle_edges,handle,pre_steps,"
    "scenario,thickness_m,range_m,edge_m,thrown_m_s,radius_m,friction,creep_speed_m_s,"
    "friction_rounds,closed_to_m,layers";

}  // namespace drape
