// SPDX-License-Identifier: Apache-2.0
#include "losses/silhouette/soft_silhouette.h"

#include <glog/logging.h>

#include "losses/silhouette/raster.h"
#include "losses/silhouette/silhouette_edges.h"

namespace drape {
namespace {

using Eigen::Matrix2Xd;

// The border point nearest to a pixel.
struct Contact {
  PieceContact at;
  int piece = -1;
};

// The nearest contact of each pixel within `reach` [px] of the border.
std::vector<Contact> FindContacts(const Matrix2Xd& points, const SilhouetteEdges& edges,
                                  const Camera& camera, double reach) {
  std::vector<Contact> contacts(size_t(camera.width) * camera.height, Contact{{reach, 0, -1}, -1});
  for (size_t i = 0; i < edges.pieces.size(); ++i) {
    const SilhouettePiece& piece = edges.pieces[i];
    const PieceBox box = BoundingBox(points.data(), piece, reach);
    const PixelRange rows = PixelsIn(box.min.y, box.max.y, camera.height);
    const PixelRange columns = PixelsIn(box.min.x, box.max.x, camera.width);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int col = columns.first; col <= columns.last; ++col) {
        const PieceContact at = NearestOnPiece(points.data(), piece, {double(col), double(row)});
        Contact& best = contacts[size_t(row) * camera.width + col];
        if (at.distance < best.at.distance) best = {at, static_cast<int>(i)};
      }
    }
  }
  return contacts;
}

// Fills in the derivatives of the coverage by the vertices on which the contact depends.
void FillRamp(const Matrix2Xd& points, const SilhouetteEdges& edges, const Contact& contact,
              bool inside, double slope, const Vec2& pixel, RampPixel* ramp) {
  const SilhouettePiece& piece = edges.pieces[contact.piece];
  const Vec2 d_point = CoverageByPoint(points.data(), piece, contact.at, pixel, inside, slope);
  const int crossing = contact.at.end < 0 ? -1 : piece.crossing[contact.at.end];
  Vec2 d_image[4];
  if (crossing >= 0) {
    AdjCrossing(points.data(), edges.crossings[crossing], d_point, d_image);
  } else {
    d_image[0] = (1 - contact.at.t) * d_point;
    d_image[1] = contact.at.t * d_point;
  }
  ramp->num_vertices = crossing >= 0 ? 4 : 2;
  const int* vertex = crossing >= 0 ? edges.crossings[crossing].vertex : piece.vertex;
  for (int k = 0; k < ramp->num_vertices; ++k) {
    ramp->vertex[k] = vertex[k];
    ramp->d_image[k] = {d_image[k].x, d_image[k].y};
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
    const SoftRamp at = RampAt(contact.at.distance, covered[i] != 0, options.half_width);
    silhouette->coverage[i] = at.coverage;
    RampPixel& ramp = silhouette->ramp.emplace_back();
    ramp.pixel = static_cast<int>(i);
    const Vec2 pixel{double(i % camera.width), double(i / camera.width)};
    FillRamp(points, edges, contact, covered[i] != 0, at.slope, pixel, &ramp);
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
  const Projection projection = camera.projection();
  for (int i = 0; i < d_image.cols(); ++i) {
    if (d_image.col(i).isZero(0)) continue;
    double by_x[3];
    projection.AdjProject(&x[3 * i], {d_image(0, i), d_image(1, i)}, by_x);
    for (int d = 0; d < 3; ++d) (*gradient)[3 * i + d] += by_x[d];
  }
}

GrayImage ToGrayImage(const SoftSilhouette& silhouette) {
  GrayImage image(silhouette.width, silhouette.height);
  Eigen::Map<Eigen::VectorXf>(image.coverage.data(), image.coverage.size()) =
      silhouette.coverage.cast<float>();
  return image;
}

}  // namespace drape
