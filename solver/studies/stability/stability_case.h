// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/state.h"
#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/laws/law_kind.h"
#include "physics/material/material.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/statics/statics.h"

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

// "step time_step=0.1 tangle=0.2": the method and whatever is unusual. Equal names are equal cases.
std::string CaseName(const StabilityCase& run);
// All members by the names of their axes.
nlohmann::json CaseJson(const StabilityCase& run);

// A method over two axes.
struct StabilityMap {
  std::string name;  // of its files: "explicit-time_step-stiffness", then what is set besides
  StabilityCase base;
  const StabilityAxis* axis[2] = {};  // across, up
  std::vector<double> values[2];      // ascending

  StabilityCase At(int i, int j) const;
  // Row by row: At(0, 0), At(1, 0), …
  std::vector<StabilityCase> Cases() const;
};

// One map for each method that a line names:
//   "step+implicit time_step=1e-4:0.5:9 stiffness=1e-3:1e3:7 density=0.1 law=reference"
// Values are a list "0/0.1/0.2", or from:to:count, evenly spaced by ratio. Two axes have more than
// one value, and the first is across; the others are set. Throws InputError, starting with `where`.
std::vector<StabilityMap> ParseStabilityMaps(const std::string& line, const std::string& where);

// Methods of one interface, to compare their limits. Two integrators are in production:
// MakeLinearlyImplicitEuler with StepLinearSolver::kDirect calls AdvanceOneStep
// (physics/simulation/rollout.h), the step of every rollout, and MakeImplicitEuler calls
// ImplicitEuler, the step of garments. The others exist for the atlas alone.

// Makes one step of h. After another status than kOk the state is not to be used.
using Integrator = std::function<IntegratorStatus(State& state)>;

// Semi-implicit (symplectic) Euler, handles as springs: v ← (v + h·M⁻¹·f)/(1 + h·drag),
// x ← x + h·v. It damps nothing by itself: drag [1/s] ≥ 0 is that of air. Stable for
// h < 2/ω·√(1 + h·drag/2), ω the highest frequency (HighestEigenvalue).
Integrator MakeExplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h, double drag);

// What solves the linear system of [MODEL, M30].
enum class StepLinearSolver {
  kDirect,  // MakeLinearSolver, as in production
  kPcg,     // conjugate gradients with incomplete Cholesky factors, both Eigen's
  kFloat    // state, matrix, right-hand side and factor (Eigen's LLT) in float; the elements are
            // evaluated in double at the rounded positions
};
struct PcgOptions {
  double tolerance = 1e-10;  // ‖b − A·v‖ ≤ tolerance·‖b‖
  int max_iterations = 500;
};
// The production step: one Newton iteration of implicit Euler, so one linear solve a step.
Integrator MakeLinearlyImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                                     const MaterialField& material, double h,
                                     StepLinearSolver solver, const PcgOptions& pcg = {});

// ImplicitEuler (physics/simulation/implicit_euler.h).
Integrator MakeImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h,
                             const ImplicitEulerOptions& options = {});

// Newton's method for a drape at rest by textbook means, which SolveEquilibrium does not use.

// K at x, the symmetric part of each element's stiffness cut to its positive semidefinite part
// [Teran 2005]: a StepMatrix, to be used with kNoShift.
void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K);

// EquilibriumOptions::shift of K as it is: where it is not positive definite there is no step.
inline constexpr StiffnessShift kNoShift = {
    .length = 0.0, .first = std::numeric_limits<double>::min(), .most = 0.0};

// Whether Newton's method gave up because K could not be factored. Exact under kNoShift, where each
// step is one factorisation.
inline bool EndedByFactorisation(const EquilibriumResult& result) {
  return result.status == EquilibriumStatus::kNotConverged &&
         result.factorisations == result.iterations + 1;
}

}  // namespace drape
