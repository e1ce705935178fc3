// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "losses/metrics/metrics.h"
#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"
#include "solver/forward/settle.h"

namespace drape {

// A shape against the image.
struct MeasuredDrape {
  Eigen::VectorXd x;  // [m], shape [3V]
  SilhouetteMetrics metrics;
};

// A fitted drape against its image, whether it is at rest (a drape that only fits while it still
// falls is no fit), and whether it is the one that the fabric takes by itself.
struct DrapeReport {
  MeasuredDrape fitted;
  double force_residual = 0.0;         // ‖f‖ / weight
  Eigen::VectorXd lowest_eigenvalues;  // of K by mass [s⁻²], ascending (LowestEigenvalues); the
                                       // drape is stable when they are positive
  MeasuredDrape settled;               // after more steps from rest
  double settled_force_residual = 0.0;
  double moved = 0.0;                         // largest distance of a vertex on the way [m]
  RolloutStatus status = RolloutStatus::kOk;  // of these steps; unless kOk, settled is fitted
  // The drapes of the fitted material from other starts; none where they do not come to rest.
  std::optional<MeasuredDrape> from_seed, from_flat;
};

// Angles of the profiles that are compared.
inline constexpr int kReportAngles = 360;

struct DrapeReportOptions {
  RolloutOptions settle;   // the further steps
  SettleOptions replay;    // from the seed and from flat
  double seed_lift = 1.0;  // of the seed
};

// Reports the drape x of a target. False when x has no outline. `solver` works on the backend's
// model.
bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& target, const Eigen::VectorXd& x,
                 const DrapeReportOptions& options, DrapeReport* report);

}  // namespace drape
