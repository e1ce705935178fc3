// SPDX-License-Identifier: Apache-2.0
#include "solver/job/drape_report.h"

#include <utility>

#include "losses/outline/hem_estimate.h"
#include "losses/outline/outline.h"
#include "losses/outline/overlay.h"
#include "losses/silhouette/raster.h"
#include "physics/cloth/state.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/statics/modes.h"
#include "solver/fit/protocol/initial_guess.h"

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
                                      fitted.radius, observation.camera, observation.discs);
  // The drape coefficient of a photograph is that of the drape's vertical projection.
  const Camera above;
  if (observation.camera.kind == CameraKind::kPinhole &&
      OutlineFromMesh(mesh, x, above, kReportAngles, &fitted))
    drape->metrics.fitted = MeasureShape(MetresFromPixels(fitted.radius, above), observation.discs);
  drape->x = std::move(x);
  return true;
}

std::optional<MeasuredDrape> MeasureSettled(const Mesh& mesh, const Observation& observation,
                                            SettledDrape settled, SolveMode mode) {
  MeasuredDrape drape;
  if (!settled.IsUsable(mode) || !Measure(mesh, observation, std::move(settled.rest.x), &drape))
    return std::nullopt;
  return drape;
}

// The drape moved so that a camera of this scale, centred in the image, sees it where the image has
// it. That of a photograph stays where it is: its camera file says where the support is.
Eigen::VectorXd SeenFromNominalCamera(const Eigen::VectorXd& x, const Camera& camera) {
  if (camera.kind == CameraKind::kPinhole) return x;
  const double cx = 0.5 * (camera.width - 1), cy = 0.5 * (camera.height - 1);
  Eigen::VectorXd moved = x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    moved[i] += (camera.cx - cx) / camera.pixels_per_metre();
    moved[i + 1] -= (camera.cy - cy) / camera.pixels_per_metre();
  }
  return moved;
}

}  // namespace

bool ReportDrape(Backend& backend, StepSolver& solver, const MaterialField& material,
                 const Observation& observation, const Eigen::VectorXd& x,
                 const DrapeReportOptions& options, DrapeReport* report) {
  const ClothModel& model = backend.model();
  SettleOptions replay = options.replay;
  replay.steps.cancel = replay.equilibrium.cancel = options.cancel;
  const NudgedDrape nudged = Nudge(backend, material, x, replay.equilibrium);
  report->status = nudged.status;
  report->drift = nudged.drift;
  report->force_residual = ForceResidual(model, material, x);
  report->self_intersections = CountSelfIntersections(model.mesh, x);
  report->lowest_eigenvalues =
      LowestEigenvalues(solver, material, x, kReportedModes, options.cancel);
  const State guess = GuessState(model, observation, options.lift), flat = model.RestState();
  report->from_guess = MeasureSettled(model.mesh, observation,
                                      SettleGuided(backend, material, guess, observation, replay),
                                      replay.solve_mode);
  report->from_flat = MeasureSettled(
      model.mesh, observation, std::move(Settle(backend, material, {&flat, 1}, replay).front()),
      replay.solve_mode);
  if (const auto radius = observation.MeasureRadius(kReportAngles))
    report->laboratory = MeasureLaboratoryDrape(
        VerticalProfile(*radius, observation.outline_camera(), observation.discs),
        observation.discs);
  return Measure(model.mesh, observation, x, &report->fitted) &&
         Measure(model.mesh, observation, nudged.x, &report->settled);
}

std::vector<std::string> ListDrapeFiles(const Observation& observation) {
  return {"fit_" + observation.name + ".png", "drape_" + observation.name + ".obj",
          "start_" + observation.name + ".json"};
}

void WriteDrape(const std::string& folder, const Mesh& mesh, const Observation& observation,
                const DrapeReport& drape) {
  if (drape.fitted.x.size() == 0) return;
  const std::vector<std::string> files = ListDrapeFiles(observation);
  Outline image, fitted;
  if (OutlineFromImage(observation.image, observation.camera, kReportAngles, &image) &&
      OutlineFromMesh(mesh, drape.fitted.x, observation.camera, kReportAngles, &fitted)) {
    WritePng(RenderOverlay(observation.image, image.radius, fitted.radius, observation.camera,
                           observation.discs),
             folder + "/" + files[0]);
  }
  WriteObj(folder + "/" + files[1], mesh, SeenFromNominalCamera(drape.fitted.x, observation.camera),
           observation.discs);
  WriteState(folder + "/" + files[2],
             {drape.fitted.x, Eigen::VectorXd::Zero(drape.fitted.x.size())});
}

}  // namespace drape
