// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/start_shape.h"
#include "physics/material/material.h"
#include "solver/studies/stability/stability_outcome.h"

namespace drape {

// What all runs of an atlas share.
struct StabilitySetting {
  Mesh mesh;
  MaterialField material;  // its density is each case's own
  StartShape start;
  int seed = 1;                // of tangled starts
  double duration = 6.0;       // simulated [s]; at least 40 steps
  int max_steps = 600;         // of an implicit method
  int max_newton_steps = 200;  // of a static one
  int max_explicit_steps = 60000;
  double max_seconds = 60.0;  // of a run; what is not at rest by then is still moving
  double drag = 8.0;          // of the explicit method, which damps nothing [1/s]
  StabilityRules rules = {};
};

struct StabilityRun {
  StabilityOutcome outcome = StabilityOutcome::kSettled;
  int steps = 0;  // of time or, of a static method, of Newton
  double seconds = 0.0;
  // Absent where the end is not finite, and the distance also where no reference drape was found.
  std::optional<double> residual;  // ‖f‖ by weight
  std::optional<double> speed;     // [m/s]
  std::optional<double> distance;  // to the reference drape [m], VertexDistance
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
  // The run's own integrator; of a static method the one-solve step before it.
  std::unique_ptr<Integrator> MakeStep(const StabilityCase& run, const StabilityScene& scene) const;

  // The drape of the case from its start shape, neither compressed nor tangled: one-solve steps of
  // 0.05 s, then Newton, and again until it is stable; shape [3V], empty when none is found. Made
  // once for all cases that share it.
  const Eigen::VectorXd& ReferenceShape(const StabilityCase& run);

  // Returns nothing when `cancel` turned true. Throws InputError where a scene cannot be made.
  std::optional<StabilityRun> Run(const StabilityCase& run, const std::atomic<bool>& cancel);

 private:
  struct Reference {
    std::once_flag once;
    Eigen::VectorXd x;
  };

  StabilitySetting setting_;
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Reference>> references_;
};

}  // namespace drape
