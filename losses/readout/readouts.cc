// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/readouts.h"

#include <glog/logging.h>

#include <utility>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr int kProfileAngles = 360;

ReadoutJacobian CoverageJacobian(const SoftSilhouette& silhouette, const Eigen::VectorXd& x,
                                 const Camera& camera) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const RampPixel& ramp : silhouette.ramp)
    for (int k = 0; k < ramp.num_vertices; ++k) {
      const int dof = 3 * ramp.vertex[k];
      double by_x[3];
      camera.AdjProject(&x[dof], ramp.d_image[k], by_x);
      for (int d = 0; d < 3; ++d) entries.emplace_back(ramp.pixel, dof + d, by_x[d]);
    }
  ReadoutJacobian jacobian(silhouette.coverage.size(), x.size());
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

}  // namespace

OutlineReadout::OutlineReadout(const Mesh& mesh, const Camera& camera, int num_angles)
    : mesh_(mesh), camera_(camera), num_angles_(num_angles) {
  CHECK_GT(num_angles, 0);
}

bool OutlineReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                          ReadoutJacobian* dr_dx) const {
  Outline outline;
  if (!OutlineFromMesh(mesh_, x, camera_, num_angles_, &outline)) return false;
  if (dr_dx != nullptr) *dr_dx = OutlineJacobian(outline, mesh_.num_vertices());
  *r = std::move(outline.radius);
  return true;
}

bool PositionReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                           ReadoutJacobian* dr_dx) const {
  if (!x.allFinite()) return false;
  *r = x;
  if (dr_dx == nullptr) return true;
  dr_dx->resize(size_, size_);
  dr_dx->setIdentity();
  return true;
}

FeatureReadout::FeatureReadout(const Mesh& mesh, const DrapeDiscs& discs)
    : discs_(discs), above_(CameraAbove(discs)), outline_(mesh, above_, kProfileAngles) {}

bool FeatureReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                          ReadoutJacobian* dr_dx) const {
  Eigen::VectorXd pixels;
  ReadoutJacobian by_x;
  if (!outline_.Read(x, &pixels, dr_dx != nullptr ? &by_x : nullptr)) return false;
  const Eigen::VectorXd radius = MetresFromPixels(pixels, above_);
  *r = ListShapeFeatures(MeasureShape(radius, discs_));
  if (dr_dx == nullptr) return true;
  const Eigen::MatrixXd by_radius = ShapeFeatureJacobian(radius, discs_);
  *dr_dx = (by_radius.sparseView() * by_x) / above_.pixels_per_metre();
  return true;
}

SilhouetteReadout::SilhouetteReadout(const Mesh& mesh, const Camera& camera,
                                     const SoftSilhouetteOptions& options)
    : mesh_(mesh), camera_(camera), options_(options) {
  CHECK_GT(options.half_width, 0);
}

bool SilhouetteReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                             ReadoutJacobian* dr_dx) const {
  SoftSilhouette silhouette;
  if (!RenderSoft(mesh_, x, camera_, options_, &silhouette)) return false;
  if (dr_dx != nullptr) *dr_dx = CoverageJacobian(silhouette, x, camera_);
  *r = std::move(silhouette.coverage);
  return true;
}

std::unique_ptr<Readout> MakeReadout(const ReadoutChoice& choice, const Mesh& mesh,
                                     const DrapeDiscs& discs) {
  choice.camera.Check("camera");
  if (choice.num_angles < 1)
    throw InputError("num_angles", Format("found %d, expected at least 1", choice.num_angles));
  if (!(choice.half_width > 0.0))
    throw InputError("half_width", Format("found %g px, expected more than 0", choice.half_width));
  if (choice.of == "positions") return std::make_unique<PositionReadout>(mesh);
  if (choice.of == "outline")
    return std::make_unique<OutlineReadout>(mesh, choice.camera, choice.num_angles);
  if (choice.of == "features") return std::make_unique<FeatureReadout>(mesh, discs);
  if (choice.of == "silhouette")
    return std::make_unique<SilhouetteReadout>(mesh, choice.camera,
                                               SoftSilhouetteOptions{choice.half_width});
  throw InputError(
      "readout", "found '" + choice.of + "', expected positions, outline, features or silhouette");
}

}  // namespace drape
