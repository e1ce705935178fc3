// SPDX-License-Identifier: Apache-2.0
#include "solver/drape_report.h"

#include "losses/outline.h"
#include "losses/raster.h"

namespace drape {
namespace {

bool Measure(const Mesh& mesh, const Target& target, const Eigen::VectorXd& x,
             SilhouetteMetrics* metrics) {
  constexpr int kSupersample = 4;
  Outline image, fitted;
  if (!OutlineFromImage(target.image, target.camera, kReportAngles, &image) ||
      !OutlineFromMesh(mesh, x, target.camera, kReportAngles, &fitted)) {
    return false;
  }
  *metrics = CompareSilhouettes(target.image, image.radius,
                                Rasterize(mesh, x, target.camera, kSupersample), fitted.radius,
                                target.camera);
  return true;
}

}  // namespace

bool ReportDrape(Backend& backend, const MaterialField& material, const Target& target,
                 const Eigen::VectorXd& x, const RolloutOptions& settle, DrapeReport* report) {
  const ClothModel& model = backend.model();
  const State rest{x, Eigen::VectorXd::Zero(x.size())};
  const RolloutInput input{&material, &rest};
  const RolloutResult fallen = backend.Rollouts({&input, 1}, settle, nullptr).front();
  report->x = x;
  report->status = fallen.status;
  report->settled_x = fallen.status == RolloutStatus::kOk ? fallen.end.x : x;
  report->moved =
      (report->settled_x - x).reshaped(3, x.size() / 3).colwise().norm().maxCoeff();
  report->force_residual = ForceResidual(model, material, x);
  report->settled_force_residual = ForceResidual(model, material, report->settled_x);
  return Measure(model.mesh, target, x, &report->metrics) &&
         Measure(model.mesh, target, report->settled_x, &report->settled);
}

}  // namespace drape
