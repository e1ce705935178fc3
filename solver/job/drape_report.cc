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

bool Measure(const Mesh& mesh, const Observation& target, Eigen::VectorXd x, MeasuredDrape* drape) {
  constexpr int kSupersample = 4;
  Outline image, fitted;
  if (!OutlineFromImage(target.image, target.camera, kReportAngles, &image) ||
      !OutlineFromMesh(mesh, x, target.camera, kReportAngles, &fitted)) {
    return false;
  }
  drape->metrics = CompareSilhouettes(target.image, image.radius,
                                      Rasterize(mesh, x, target.camera, kSupersample),
                                      fitted.radius, target.camera);
  drape->x = std::move(x);
  return true;
}

std::optional<MeasuredDrape> Replay(Backend& backend, const MaterialField& material,
                                    const Observation& target, const State& start,
                                    const SettleOptions& options) {
  SettledDrape settled = std::move(Settle(backend, material, {&start, 1}, options).front());
  MeasuredDrape drape;
  if (!settled.IsUsable(options.integrator) ||
      !Measure(backend.model().mesh, target, std::move(settled.rest.x), &drape))
    return std::nullopt;
  return drape;
}

}  // namespace

bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& target, const Eigen::VectorXd& x,
                 const DrapeReportOptions& options, DrapeReport* report) {
  const ClothModel& model = backend.model();
  const State rest{x, Eigen::VectorXd::Zero(x.size())};
  const RolloutInput input{&material, &rest};
  const RolloutResult fallen = backend.Rollouts({&input, 1}, options.settle, nullptr).front();
  const Eigen::VectorXd& end = fallen.status == RolloutStatus::kOk ? fallen.end.x : x;
  report->status = fallen.status;
  report->moved = (end - x).reshaped(3, x.size() / 3).colwise().norm().maxCoeff();
  report->force_residual = ForceResidual(model, material, x);
  report->settled_force_residual = ForceResidual(model, material, end);
  report->lowest_eigenvalues = LowestEigenvalues(solver, material, x, kReportedModes);
  report->from_seed = Replay(backend, material, target,
                             GuessState(model, target, options.seed_lift), options.replay);
  report->from_flat = Replay(backend, material, target, model.RestState(), options.replay);
  return Measure(model.mesh, target, x, &report->fitted) &&
         Measure(model.mesh, target, end, &report->settled);
}

}  // namespace drape
