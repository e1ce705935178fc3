// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/view_readouts.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <utility>

namespace drape {
namespace {

using Eigen::Vector3d;
using Entries = std::vector<Eigen::Triplet<double>>;

// ∂coverage/∂x; seen: the positions in the frame of the camera.
ReadoutJacobian CoverageJacobian(const SoftSilhouette& silhouette, const Eigen::VectorXd& seen,
                                 const View& view) {
  Entries entries;
  for (const RampPixel& ramp : silhouette.ramp)
    for (int k = 0; k < ramp.num_vertices; ++k) {
      const int dof = 3 * ramp.vertex[k];
      Vector3d by_seen;
      view.camera.AdjProject(&seen[dof], ramp.d_image[k], by_seen.data());
      const Vector3d by_x = view.AdjFromWorld(by_seen);
      for (int d = 0; d < 3; ++d) entries.emplace_back(ramp.pixel, dof + d, by_x[d]);
    }
  ReadoutJacobian jacobian(silhouette.coverage.size(), seen.size());
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

}  // namespace

SilhouetteReadout::SilhouetteReadout(const Mesh& mesh, const View& view,
                                     const SoftSilhouetteOptions& options)
    : mesh_(mesh), view_(view), options_(options) {
  CHECK_GT(options.half_width, 0);
}

bool SilhouetteReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                             ReadoutJacobian* dr_dx) const {
  SoftSilhouette silhouette;
  const Eigen::VectorXd seen = view_.FromWorld(x);
  if (!RenderSoft(mesh_, seen, view_.camera, options_, &silhouette)) return false;
  if (dr_dx != nullptr) *dr_dx = CoverageJacobian(silhouette, seen, view_);
  *r = std::move(silhouette.coverage);
  return true;
}

DepthReadout::DepthReadout(const Mesh& mesh, const View& view, std::vector<int> pixels,
                           double background)
    : mesh_(mesh), view_(view), pixels_(std::move(pixels)), background_(background) {
  for (const int pixel : pixels_)
    CHECK(pixel >= 0 && pixel < view_.camera.width * view_.camera.height) << pixel;
}

// The ray o + depth·d meets the plane of the face, n·(o + depth·d − a) = 0. A move δ of its corners
// moves the plane by n·Σ wδ at the place that is seen.
Eigen::Matrix3d DepthReadout::DepthByCorners(const Eigen::VectorXd& seen,
                                             const SurfaceHit& hit) const {
  const Camera& camera = view_.camera;
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k) corners.col(k) = seen.segment<3>(3 * mesh_.faces[hit.face].vertex[k]);
  const Vector3d n = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
  Vector3d along(0, 0, -1);  // d
  if (camera.is_pinhole())
    along = (corners * hit.weight - Vector3d(camera.eye_x, camera.eye_y, camera.eye_height)) /
            hit.depth;
  return n / n.dot(along) * hit.weight.transpose();
}

bool DepthReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                        ReadoutJacobian* dr_dx) const {
  const Eigen::VectorXd seen = view_.FromWorld(x);
  std::vector<SurfaceHit> hits;
  if (!FindVisible(mesh_, seen, view_.camera, &hits)) return false;
  r->setConstant(size(), background_);
  Entries entries;
  for (int k = 0; k < size(); ++k) {
    const SurfaceHit& hit = hits[pixels_[k]];
    if (hit.face < 0) continue;
    (*r)[k] = hit.depth;
    if (dr_dx == nullptr) continue;
    const Eigen::Matrix3d by_corners = DepthByCorners(seen, hit);
    for (int i = 0; i < 3; ++i) {
      const Vector3d by_x = view_.AdjFromWorld(by_corners.col(i));
      for (int d = 0; d < 3; ++d)
        entries.emplace_back(k, 3 * mesh_.faces[hit.face].vertex[i] + d, by_x[d]);
    }
  }
  if (dr_dx == nullptr) return true;
  dr_dx->resize(size(), x.size());
  dr_dx->setFromTriplets(entries.begin(), entries.end());
  return true;
}

}  // namespace drape
