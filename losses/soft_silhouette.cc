// SPDX-License-Identifier: Apache-2.0
#include "losses/soft_silhouette.h"

#include <glog/logging.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "losses/raster.h"
#include "losses/silhouette_edges.h"

namespace drape {
namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;

constexpr double kOnBorder = 1e-9;  // [px] below this the offset from the border has no direction

// Nearest border point of a pixel.
struct Contact {
  double distance;
  int piece = -1;
  double t;           // on the piece's edge
  int crossing = -1;  // the contact is this crossing
};

Contact NearestOnPiece(const Matrix2Xd& points, const SilhouettePiece& piece, int index,
                       const Vector2d& pixel) {
  const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
  Contact contact{0, index, (pixel - a).dot(e) / e.squaredNorm(), -1};
  for (int end = 0; end < 2; ++end) {
    const bool beyond = end == 0 ? contact.t <= piece.t[0] : contact.t >= piece.t[1];
    if (!beyond) continue;
    contact.t = piece.t[end];
    contact.crossing = piece.crossing[end];
    break;
  }
  contact.distance = (pixel - a - contact.t * e).norm();
  return contact;
}

// Nearest contact of each pixel within `reach` of the border.
std::vector<Contact> FindContacts(const Matrix2Xd& points, const SilhouetteEdges& edges,
                                  const Camera& camera, double reach) {
  std::vector<Contact> contacts(size_t(camera.width) * camera.height, Contact{reach, -1, 0, -1});
  for (size_t i = 0; i < edges.pieces.size(); ++i) {
    const SilhouettePiece& piece = edges.pieces[i];
    const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
    const Vector2d p = a + piece.t[0] * e, q = a + piece.t[1] * e;
    const auto first = [&](double v, int size) {
      return int(std::clamp(std::ceil(v), 0.0, double(size)));
    };
    const auto last = [&](double v, int size) {
      return int(std::clamp(std::floor(v), -1.0, size - 1.0));
    };
    const Vector2d min = p.cwiseMin(q).array() - reach, max = p.cwiseMax(q).array() + reach;
    for (int row = first(min.y(), camera.height); row <= last(max.y(), camera.height); ++row) {
      for (int col = first(min.x(), camera.width); col <= last(max.x(), camera.width); ++col) {
        const Contact contact = NearestOnPiece(points, piece, static_cast<int>(i), {col, row});
        Contact& best = contacts[size_t(row) * camera.width + col];
        if (contact.distance < best.distance) best = contact;
      }
    }
  }
  return contacts;
}

// A crossing X lies on both edges: n·δX = (1−t) n·δa + t n·δb for the normal n of each. Writing
// the adjoint of X in the basis of the two normals hands each share to the ends of its own edge.
void AdjCrossing(const Matrix2Xd& points, const EdgeCrossing& crossing, const Vector2d& d_point,
                 RampPixel* ramp) {
  Eigen::Matrix2d normals;
  for (int k = 0; k < 2; ++k) {
    const Vector2d e = points.col(crossing.vertex[2 * k + 1]) - points.col(crossing.vertex[2 * k]);
    normals.col(k) = Vector2d(-e.y(), e.x());
  }
  const double det = normals.determinant();
  const double share[2] = {(d_point.x() * normals(1, 1) - d_point.y() * normals(0, 1)) / det,
                           (d_point.y() * normals(0, 0) - d_point.x() * normals(1, 0)) / det};
  ramp->num_vertices = 4;
  for (int k = 0; k < 4; ++k) {
    const double t = crossing.t[k / 2];
    ramp->vertex[k] = crossing.vertex[k];
    ramp->d_image[k] = share[k / 2] * (k % 2 == 0 ? 1 - t : t) * normals.col(k / 2);
  }
}

// Derivative of the signed distance times `slope` by the vertices that hold the contact. By the
// envelope theorem the contact's position on the edge counts as fixed.
void FillRamp(const Matrix2Xd& points, const SilhouetteEdges& edges, const Contact& contact,
              const Vector2d& pixel, double sign, double slope, RampPixel* ramp) {
  const SilhouettePiece& piece = edges.pieces[contact.piece];
  const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
  const Vector2d inward = contact.distance < kOnBorder
                              ? piece.inward
                              : Vector2d(sign / contact.distance * (pixel - a - contact.t * e));
  const Vector2d d_point = -slope * inward;
  if (contact.crossing >= 0) {
    AdjCrossing(points, edges.crossings[contact.crossing], d_point, ramp);
    return;
  }
  ramp->num_vertices = 2;
  for (int k = 0; k < 2; ++k) {
    ramp->vertex[k] = piece.vertex[k];
    ramp->d_image[k] = (k == 0 ? 1 - contact.t : contact.t) * d_point;
  }
}

}  // namespace

bool RenderSoft(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                const SoftSilhouetteOptions& options, SoftSilhouette* silhouette) {
  CHECK_GT(options.half_width, 0);
  Matrix2Xd points;
  if (!ProjectVertices(x, camera, &points)) return false;
  const SilhouetteEdges edges = FindSilhouetteEdges(mesh, points);
  const auto contacts = FindContacts(points, edges, camera, options.half_width);
  const auto covered = CoveredPixels(mesh, points, camera.width, camera.height);
  silhouette->width = camera.width;
  silhouette->height = camera.height;
  silhouette->coverage.resize(covered.size());
  silhouette->ramp.clear();
  for (size_t i = 0; i < covered.size(); ++i) {
    const Contact& contact = contacts[i];
    silhouette->coverage[i] = covered[i];
    if (contact.piece < 0) continue;
    const double sign = covered[i] ? 1 : -1;
    const double u = 0.5 * (1 + sign * contact.distance / options.half_width);
    silhouette->coverage[i] = u * u * (3 - 2 * u);
    RampPixel& ramp = silhouette->ramp.emplace_back();
    ramp.pixel = static_cast<int>(i);
    FillRamp(points, edges, contact, Vector2d(i % camera.width, i / camera.width), sign,
             3 * u * (1 - u) / options.half_width, &ramp);
  }
  return true;
}

void AdjRenderSoft(const SoftSilhouette& silhouette, const Eigen::VectorXd& x, const Camera& camera,
                   const Eigen::VectorXd& pixel_adjoint, Eigen::VectorXd* gradient) {
  CHECK_EQ(pixel_adjoint.size(), silhouette.coverage.size());
  CHECK_EQ(gradient->size(), x.size());
  Matrix2Xd d_image = Matrix2Xd::Zero(2, x.size() / 3);
  for (const RampPixel& ramp : silhouette.ramp) {
    for (int k = 0; k < ramp.num_vertices; ++k) {
      d_image.col(ramp.vertex[k]) += pixel_adjoint[ramp.pixel] * ramp.d_image[k];
    }
  }
  for (int i = 0; i < d_image.cols(); ++i) {
    if (d_image.col(i).isZero(0)) continue;
    gradient->segment<3>(3 * i) +=
        camera.ImageFromWorldJacobian(&x[3 * i]).transpose() * d_image.col(i);
  }
}

GrayImage ToGrayImage(const SoftSilhouette& silhouette) {
  GrayImage image(silhouette.width, silhouette.height);
  Eigen::Map<Eigen::VectorXf>(image.coverage.data(), image.coverage.size()) =
      silhouette.coverage.cast<float>();
  return image;
}

}  // namespace drape
