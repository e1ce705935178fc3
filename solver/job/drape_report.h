// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"
#include "solver/forward/settle.h"

namespace drape {

// A shape and how far it is from the image.
struct MeasuredDrape {
  Eigen::VectorXd x;  // [m], shape [3V]
  SilhouetteMetrics metrics;
};

// A fitted drape against its image, whether it is an equilibrium (a transient shape that matches
// the image is no fit), and whether the fabric comes to it by itself.
struct DrapeReport {
  MeasuredDrape fitted;
  double force_residual = 0.0;         // ‖f‖ / weight
  int self_intersections = 0;          // of the fitted drape (CountSelfIntersections)
  Eigen::VectorXd lowest_eigenvalues;  // of K by mass [s⁻²], ascending (LowestEigenvalues); the
                                       // drape is stable when they are positive
  // Where the fitted drape comes to rest when it is nudged, as in NudgedDrape.
  MeasuredDrape settled;
  double drift = 0.0;  // [m]
  EquilibriumStatus status = EquilibriumStatus::kStable;
  // The drapes of the fitted material from other starts; none where they are not stable.
  std::optional<MeasuredDrape> from_guess, from_flat;
  LaboratoryDrape laboratory;  // of the image
};

// Angles of the profiles that are compared.
inline constexpr int kReportAngles = 360;

struct DrapeReportOptions {
  SettleOptions replay;  // from the initial guess and from flat; its equilibrium for all
  double lift = 1.0;     // of the initial guess
  // When it turns true, what a report tells beyond the fitted drape is left out: no nudges (status
  // kCancelled), eigenvalues and drapes from other starts.
  const std::atomic<bool>* cancel = nullptr;
};

// Reports the drape x of an observation. False when x has no outline. `solver` works on the
// backend's model.
bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& observation, const Eigen::VectorXd& x,
                 const DrapeReportOptions& options, DrapeReport* report);

// The names of the files of a fitted drape: a picture of the outlines, the mesh, and its state as a
// start for other programs.
std::vector<std::string> ListDrapeFiles(const Observation& observation);
// Writes them, each atomically; nothing for a drape that has no outline. Throws InputError when one
// cannot be written.
void WriteDrape(const std::string& folder, const Mesh& mesh, const Observation& observation,
                const DrapeReport& drape);

}  // namespace drape
