// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "losses/metrics.h"
#include "physics/backend.h"
#include "solver/target.h"

namespace drape {

// A fitted drape against its image, and whether it is at rest: a drape that only fits while it
// still falls is no fit.
struct DrapeReport {
  Eigen::VectorXd x;             // [m], shape [3V]
  SilhouetteMetrics metrics;     // at x
  double force_residual = 0.0;   // ‖f‖ / weight at x
  Eigen::VectorXd settled_x;     // x after more steps from rest
  SilhouetteMetrics settled;
  double settled_force_residual = 0.0;
  double moved = 0.0;            // largest distance of a vertex on the way [m]
  RolloutStatus status = RolloutStatus::kOk;  // of these steps; unless kOk, settled_x = x
};

// Angles of the profiles that are compared.
inline constexpr int kReportAngles = 360;

// False when a drape has no outline.
bool ReportDrape(Backend& backend, const MaterialField& material, const Target& target,
                 const Eigen::VectorXd& x, const RolloutOptions& settle, DrapeReport* report);

}  // namespace drape
