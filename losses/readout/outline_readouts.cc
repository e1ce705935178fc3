// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/outline_readouts.h"

#include <glog/logging.h>

#include <cmath>
#include <complex>
#include <utility>

namespace drape {
namespace {

constexpr int kProfileAngles = 360;

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

ProjectionReadout::ProjectionReadout(const Mesh& mesh, const DrapeDiscs& discs)
    : above_(CameraAbove(discs)), outline_(mesh, above_, kProfileAngles) {}

bool ProjectionReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                             ReadoutJacobian* dr_dx) const {
  if (!outline_.Read(x, r, dr_dx)) return false;
  *r = MetresFromPixels(*r, above_);
  if (dr_dx != nullptr) *dr_dx /= above_.pixels_per_metre();
  return true;
}

bool FeatureReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                          ReadoutJacobian* dr_dx) const {
  Eigen::VectorXd radius;
  ReadoutJacobian by_x;
  if (!profile_.Read(x, &radius, dr_dx != nullptr ? &by_x : nullptr)) return false;
  *r = ListShapeFeatures(MeasureShape(radius, discs_));
  if (dr_dx == nullptr) return true;
  const Eigen::MatrixXd by_radius = ShapeFeatureJacobian(radius, discs_);
  *dr_dx = ReadoutJacobian(by_radius.sparseView()) * by_x;
  return true;
}

SpectrumReadout::SpectrumReadout(const Mesh& mesh, const DrapeDiscs& discs, int num_modes)
    : num_modes_(num_modes), profile_(mesh, discs) {
  CHECK(num_modes > 0 && 2 * num_modes < kProfileAngles) << num_modes;
}

bool SpectrumReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                           ReadoutJacobian* dr_dx) const {
  Eigen::VectorXd radius;
  ReadoutJacobian by_x;
  if (!profile_.Read(x, &radius, dr_dx != nullptr ? &by_x : nullptr)) return false;
  r->resize(num_modes_);
  Eigen::MatrixXd by_radius = Eigen::MatrixXd::Zero(num_modes_, radius.size());
  for (int k = 1; k <= num_modes_; ++k) {
    const std::complex<double> mode = ComputeMode(radius, k);
    const double amplitude = std::abs(mode);
    (*r)[k - 1] = amplitude;
    if (amplitude == 0.0) continue;
    const Eigen::Vector2d phase(mode.real() / amplitude, mode.imag() / amplitude);
    for (int i = 0; i < kProfileAngles; ++i)
      by_radius(k - 1, i) =
          2.0 / kProfileAngles * phase.dot(RayDirection(k * i % kProfileAngles, kProfileAngles));
  }
  if (dr_dx != nullptr) *dr_dx = ReadoutJacobian(by_radius.sparseView()) * by_x;
  return true;
}

}  // namespace drape
