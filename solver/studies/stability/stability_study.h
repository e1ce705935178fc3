// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/cloth/state.h"
#include "solver/studies/runner/study.h"
#include "solver/studies/stability/stability_case.h"

namespace drape {

// How a run ended, by the first of these rules that holds.
enum class StabilityOutcome {
  kSettled,      // none of the other rules holds
  kStillMoving,  // rms speed of the vertices above 2 mm/s; or it creeps: it is slower, but the
                 // drape at rest that belongs to the shape (Newton starts from it) is the reference
                 // and the shape is not
  kOtherBranch,  // rms distance of the vertices from the reference drape above 3 mm
  kFoldedOver,   // a triangle whose corners are all held lies face down, the cloth at a hinge is
                 // folded by more than 165°, or a vertex is higher than 3 cm over the support
  kDiverged,     // a number that is not finite, or a coordinate above 2 m
  kFactorFailed,  // what the method itself reports
  kNotConverged   // the same
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

// What a method leaves behind.
struct StabilityEnd {
  IntegratorStatus status = IntegratorStatus::kOk;
  Eigen::VectorXd x;   // [m], shape [3V]
  double speed = 0.0;  // rms over the vertices [m/s]; 0 at a rest that Newton found
};

// Applies the rules in the order diverged, factor failed, not converged, folded over, still moving,
// other branch, settled. reference: the drape of the same scene, empty where none was found; then
// whatever is at rest counts as settled. rest: where Newton leads from an x, if anywhere; asked
// only when it matters.
using RestOf = std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& x)>;
StabilityOutcome Classify(const ClothModel& model, const StabilityEnd& end,
                          const Eigen::VectorXd& reference, const RestOf& rest);

// The mesh with needles: edges of the free cloth are shortened to `ratio` times their length, both
// ends drawn to the middle, 0 < ratio ≤ 1, so that the two triangles beside each have sides of
// about 1 : ratio. Of edges that share no neighbour, as many as there are, where both ends lie
// beyond `support_radius` and off the hem: the outline and the support stay. Faces and their order
// stay. Throws InputError when the mesh has no such edge. CHECKs the range of ratio.
Mesh AddSliverTriangles(const Mesh& mesh, double support_radius, double ratio);

// What all runs of an atlas share.
struct StabilitySetting {
  Mesh mesh = {};
  MaterialField material = {};  // its density is each case's own
  StartShape start = {};
  int seed = 1;                // of tangled starts
  double duration = 6.0;       // simulated [s]; at least 40 steps
  int max_steps = 600;         // of an implicit method
  int max_newton_steps = 200;  // of a static one
  int max_explicit_steps = 60000;
  double max_seconds = 60.0;  // of a run; what is not at rest by then is still moving
  double drag = 8.0;          // of the explicit method, which damps nothing [1/s]
};

// A cloth as a case of the drape test has it.
struct StabilityScene {
  std::shared_ptr<const ClothModel> model;
  MaterialField material;
  State start;  // compressed and tangled
};

// Runs cases; safe to call from many threads.
class StabilityRunner {
 public:
  explicit StabilityRunner(StabilitySetting setting) : setting_(std::move(setting)) {}

  const StabilitySetting& setting() const { return setting_; }

  StabilityScene MakeScene(const StabilityCase& run) const;

  // The results of a cell, as scripts/stability.py reads them.

  // {"outcome", "steps" (of time or, of a static method, of Newton), "seconds", "residual" (‖f‖ by
  // weight), "speed_m_s", "distance_m" (to the reference drape, VertexDistance)}. The last three
  // are null where the end is not finite, the distance also where there is no reference drape.
  // Returns nothing when `cancel` turned true. Throws InputError where a scene cannot be made.
  std::optional<nlohmann::json> Run(const StabilityCase& run, const std::atomic<bool>& cancel);

  // The largest stable time step of the explicit method, {"theory_s", "measured_s"}, each null
  // where it is not found. Theory is [Courant 1928]: ω²h² = 4 + 2·h·drag, with ω of
  // HighestEigenvalue at rest. The measured one is by bisection to 3 %: from the case's own start
  // the cloth does not diverge in 1,500 steps.
  nlohmann::json MeasureLimit(StabilityCase run) const;

  // The factor by which a step of an implicit method shrinks a small vibration about the drape at
  // rest, in the norm of its energy: mode number `mode` of LowestModes, followed for some steps.
  // Implicit Euler's factor is 1/√(1 + h²ω²) [Hairer 1996, IV.3], an exact oscillator's is 1.
  // Returns
  // {"omega_1_s", "steps", "theory" (of implicit Euler), "measured" (a step, the mean of all)}, or
  // {"omega_1_s": null} where the case has no stable drape or its method fails.
  nlohmann::json MeasureDamping(const StabilityCase& run, int mode);

 private:
  struct Reference {
    std::once_flag once;
    Eigen::VectorXd x;
  };

  // The run's own integrator; of a static method the one-solve step before it.
  Integrator MakeStep(const StabilityCase& run, const StabilityScene& scene) const;
  bool StaysBounded(const StabilityCase& run, const StabilityScene& scene) const;
  // The drape of the case from its start shape, neither compressed nor tangled: one-solve steps of
  // 0.05 s, then Newton, and again until it is stable; shape [3V], empty when none is found. Made
  // once for all cases that share it.
  const Eigen::VectorXd& ReferenceShape(const StabilityCase& run);

  StabilitySetting setting_;
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Reference>> references_;
};

// The stability atlas as a study. Its cells are the runs of all maps, each once, the limits of the
// explicit maps over the time step, and the damping of the implicit methods at these time steps.
// `runner` outlives the study. Throws InputError where a scene cannot be made.
Study MakeStabilityStudy(StabilityRunner& runner, const std::vector<StabilityMap>& maps,
                         const std::vector<double>& damping_h);

// The maps as scripts/stability.py reads them: axes, and the names of their cells row by row.
nlohmann::ordered_json MapsJson(const std::vector<StabilityMap>& maps);

}  // namespace drape
