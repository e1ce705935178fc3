// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "physics/cloth/cloth_model.h"
#include "solver/studies/stability/cases/stability_case.h"
#include "solver/studies/stability/methods/integrator.h"

namespace drape {

// What decides the outcome of a run, in this order:
// - diverged: a number that is not finite, or a coordinate above `far`;
// - factor failed, not converged: what the method itself reports;
// - folded over: a triangle whose corners are all held lies face down, the cloth at a hinge is
//   folded by more than `fold`, or a vertex is higher than `above` over the support;
// - still moving: rms speed of the vertices above `speed`; or slower than that, but the drape at
//   rest that belongs to the shape (Newton starts from it) is the reference and the shape is not:
//   it creeps;
// - other branch: rms distance of the vertices from the reference drape above `branch`;
// - settled.
struct StabilityRules {
  double far = 2.0;      // [m]
  double fold = 2.88;    // [rad], 165°
  double above = 0.03;   // [m]
  double speed = 2e-3;   // [m/s]
  double branch = 3e-3;  // [m]
};

// What a method leaves behind.
struct StabilityEnd {
  IntegratorStatus status = IntegratorStatus::kOk;
  Eigen::VectorXd x;   // [m], shape [3V]
  double speed = 0.0;  // rms over the vertices [m/s]; 0 at a rest that Newton found
};

// x is no number or far away.
bool IsLost(const Eigen::VectorXd& x, const StabilityRules& rules);
bool IsFoldedOver(const ClothModel& model, const Eigen::VectorXd& x, const StabilityRules& rules);

// reference: the drape of the same scene, empty where none was found: then whatever is at rest
// counts as settled. rest: where Newton leads from an x, if anywhere; asked only when it matters.
using RestOf = std::function<std::optional<Eigen::VectorXd>(const Eigen::VectorXd& x)>;
StabilityOutcome Classify(const ClothModel& model, const StabilityEnd& end,
                          const Eigen::VectorXd& reference, const RestOf& rest,
                          const StabilityRules& rules = {});

}  // namespace drape
