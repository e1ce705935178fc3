// SPDX-License-Identifier: Apache-2.0
#include "solver/job/drape_report.h"

#include <utility>

#include "losses/outline/outline.h"
#include "losses/silhouette/raster.h"
#include "physics/simulation/statics/modes.h"
#include "solver/fit/protocol/initial_guess_grid.h"

namespace drape {
namespace {

constexpr int kReportedModes = 3;

bool Measure(const Mesh& mesh, const Observation& observation, Eigen::VectorXd x,
             MeasuredDrape* drape) {
  constexpr int kSupersample = 4;
  Outline image, fitted;
  if (!OutlineFromImage(observation.image, observation.camera, kReportAngles, &image) ||
      !OutlineFromMesh(mesh, x, observation.camera, kReportAngles, &fitted)) {
    return false;
  }
  drape->metrics = CompareSilhouettes(observation.image, image.radius,
                                      Rasterize(mesh, x, observation.camera, kSupersample),
                                      fitted.radius, observation.camera);
  drape->x = std::move(x);
  return true;
}

std::optional<MeasuredDrape> Replay(Backend& backend, const MaterialField& material,
                                    const Observation& observation, const State& start,
                                    const SettleOptions& options) {
  SettledDrape settled = std::move(Settle(backend, material, {&start, 1}, options).front());
  MeasuredDrape drape;
  if (!settled.IsUsable(options.solve_mode) ||
      !Measure(backend.model().mesh, observation, std::move(settled.rest.x), &drape))
    return std::nullopt;
  return drape;
}

}  // namespace

bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& observation, const Eigen::VectorXd& x,
                 const DrapeReportOptions& options, DrapeReport* report) {
  const ClothModel& model = backend.model();
  const State rest{x, Eigen::VectorXd::Zero(x.size())};
  const RolloutInput input{&material, &rest};
  RolloutOptions recheck = options.recheck;
  SettleOptions replay = options.replay;
  recheck.cancel = replay.steps.cancel = replay.equilibrium.cancel = options.cancel;
  const RolloutResult rechecked = backend.Rollouts({&input, 1}, recheck, nullptr).front();
  const Eigen::VectorXd& end = rechecked.status == RolloutStatus::kOk ? rechecked.end.x : x;
  report->status = rechecked.status;
  report->drift = (end - x).reshaped(3, x.size() / 3).colwise().norm().maxCoeff();
  report->force_residual = ForceResidual(model, material, x);
  report->settled_force_residual = ForceResidual(model, material, end);
  report->lowest_eigenvalues =
      LowestEigenvalues(solver, material, x, kReportedModes, options.cancel);
  report->from_guess =
      Replay(backend, material, observation, GuessState(model, observation, options.lift), replay);
  report->from_flat = Replay(backend, material, observation, model.RestState(), replay);
  return Measure(model.mesh, observation, x, &report->fitted) &&
         Measure(model.mesh, observation, end, &report->settled);
}

}  // namespace drape
