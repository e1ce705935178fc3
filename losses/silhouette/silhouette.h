// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// Returns 1 for each pixel whose centre is covered by a triangle, row-major, shape [height, width].
// image_points: finite, [px], shape [2, V].
std::vector<uint8_t> CoveredPixels(const Mesh& mesh, const Eigen::Matrix2Xd& image_points,
                                   int width, int height);

// The hard silhouette of all triangles at positions x [m], shape [3V]: the fraction of the
// supersample² samples of each pixel that are covered. CHECKs that x is finite and in front of the
// camera.
GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample = 1);
GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample = 1);

// The elementary operations of the soft silhouette [MODEL, M48] on edges, crossings, pieces of the
// border and pixels. `points`: the projected vertices [px], shape [2, V].

inline constexpr double kBorderProbe = 1e-6;  // [px] from an edge: where its sides are probed
inline constexpr double kOnBorder = 1e-9;  // [px] distance below which the offset has no direction

// The point where the projections of the mesh edges a→b and c→d cross.
struct EdgeCrossing {
  int vertex[4];  // a, b, c, d
  double t[2];    // position on a→b and on c→d, in (0, 1)
};

// A part of a projected mesh edge that borders the union of all projected triangles.
struct SilhouettePiece {
  int vertex[2];    // the edge a→b
  double t[2];      // the piece runs from a + t[0](b−a) to a + t[1](b−a)
  int crossing[2];  // index of the crossing at each end, or −1 for an end at a vertex
  Vec2 inward;      // unit normal towards the cloth
};

// The side of the edge i→j of the projected mesh on which the point lies: twice the signed area of
// the triangle (i, j, point) [px²]. It is exactly antisymmetric in (i, j), so that two triangles
// that share an edge leave no gap between them.
inline double EdgeSide(const double* points, int i, int j, const Vec2& p) {
  const double sign = i < j ? 1 : -1;
  const Vec2 a = PointAt(points, i < j ? i : j), b = PointAt(points, i < j ? j : i);
  return sign * Cross(b - a, p - a);
}

// Returns whether the closed projected triangle of three vertices contains the point, whichever
// face is seen. A triangle of zero area contains nothing.
inline bool Covers(const double* points, const int* triangle, const Vec2& p) {
  const int a = triangle[0], b = triangle[1], c = triangle[2];
  const double ab = EdgeSide(points, a, b, p);
  const double bc = EdgeSide(points, b, c, p);
  const double ca = EdgeSide(points, c, a, p);
  const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  return inside && EdgeSide(points, a, b, PointAt(points, c)) != 0;
}

inline bool Covers(const double* points, const Face& face, const Vec2& p) {
  return Covers(points, face.vertex, p);
}

// Returns whether the two faces of a hinge overlap in the image.
inline bool FoldsOver(const double* points, const Hinge& hinge) {
  const int* v = hinge.vertex;
  return EdgeSide(points, v[0], v[1], PointAt(points, v[2])) *
             EdgeSide(points, v[0], v[1], PointAt(points, v[3])) >=
         0;
}

inline bool ShareVertex(const int l[2], const int r[2]) {
  return l[0] == r[0] || l[0] == r[1] || l[1] == r[0] || l[1] == r[1];
}

// Computes the positions t of the crossing on the edges l and r. Returns false when they do not
// cross inside both.
inline bool Intersect(const double* points, const int l[2], const int r[2], double t[2]) {
  const Vec2 l0 = PointAt(points, l[0]), r0 = PointAt(points, r[0]);
  const Vec2 e = PointAt(points, l[1]) - l0, f = PointAt(points, r[1]) - r0;
  const Vec2 offset = r0 - l0;
  const double det = Cross(e, f);
  if (det == 0) return false;
  t[0] = Cross(offset, f) / det;
  t[1] = Cross(offset, e) / det;
  return t[0] > 0 && t[0] < 1 && t[1] > 0 && t[1] < 1;
}

// Returns whether a part of an edge is a piece of the border, that is, whether exactly one of its
// sides is covered, and sets its inward normal. is_covered(point) → bool.
template <class IsCovered>
bool FindInward(const double* points, const IsCovered& is_covered, SilhouettePiece* part) {
  const Vec2 a = PointAt(points, part->vertex[0]), e = PointAt(points, part->vertex[1]) - a;
  const double length = std::sqrt(Dot(e, e));
  const Vec2 normal{-e.y / length, e.x / length};
  const Vec2 middle = a + (0.5 * (part->t[0] + part->t[1])) * e;
  const bool plus = is_covered(middle + kBorderProbe * normal);
  const bool minus = is_covered(middle - kBorderProbe * normal);
  part->inward = plus ? normal : Vec2{-normal.x, -normal.y};
  return plus != minus;
}

// The point of a piece that is nearest to a pixel.
struct PieceContact {
  double distance;  // [px]
  double t;         // position on the edge of the piece
  int end;          // 0 or 1: this end of the piece; −1: between the ends
};
inline PieceContact NearestOnPiece(const double* points, const SilhouettePiece& piece,
                                   const Vec2& pixel) {
  const Vec2 a = PointAt(points, piece.vertex[0]), e = PointAt(points, piece.vertex[1]) - a;
  double t = Dot(pixel - a, e) / Dot(e, e);
  const int end = t <= piece.t[0] ? 0 : t >= piece.t[1] ? 1 : -1;
  if (end >= 0) t = piece.t[end];
  const Vec2 offset = pixel - a - t * e;
  return {std::sqrt(Dot(offset, offset)), t, end};
}

// The columns and rows within `reach` [px] of a piece, not yet clipped to the image.
struct PieceBox {
  Vec2 min, max;
};
inline PieceBox BoundingBox(const double* points, const SilhouettePiece& piece, double reach) {
  const Vec2 a = PointAt(points, piece.vertex[0]), e = PointAt(points, piece.vertex[1]) - a;
  const Vec2 p = a + piece.t[0] * e, q = a + piece.t[1] * e;
  return {{std::fmin(p.x, q.x) - reach, std::fmin(p.y, q.y) - reach},
          {std::fmax(p.x, q.x) + reach, std::fmax(p.y, q.y) + reach}};
}
// The pixels first … last of [0, size) that lie in [min, max]; the range is empty when first >
// last.
struct PixelRange {
  int first, last;
};
inline PixelRange PixelsIn(double min, double max, int size) {
  const double end = size;
  return {static_cast<int>(std::ceil(std::fmin(std::fmax(min, 0.0), end))),
          static_cast<int>(std::floor(std::fmin(std::fmax(max, -1.0), end - 1.0)))};
}

// The coverage at a distance from the border [px], and its derivative by the signed distance [1/px]
// [MODEL, M48].
struct SoftRamp {
  double coverage, slope;
};
inline SoftRamp RampAt(double distance, bool inside, double half_width) {
  const double u = 0.5 * (1 + (inside ? 1.0 : -1.0) * distance / half_width);
  return {u * u * (3 - 2 * u), 3 * u * (1 - u) / half_width};
}

// ∂coverage/∂(point of contact) [1/px], by the envelope theorem with its position on the edge held.
inline Vec2 CoverageByPoint(const double* points, const SilhouettePiece& piece,
                            const PieceContact& contact, const Vec2& pixel, bool inside,
                            double slope) {
  if (contact.distance < kOnBorder) return -slope * piece.inward;
  const Vec2 a = PointAt(points, piece.vertex[0]), e = PointAt(points, piece.vertex[1]) - a;
  const Vec2 offset = pixel - a - contact.t * e;
  const Vec2 inward = ((inside ? 1.0 : -1.0) / contact.distance) * offset;
  return -slope * inward;
}

// A crossing X lies on both edges: n·δX = (1 − t) n·δa + t n·δb for the normal n of each. The
// adjoint of X is written in the basis of the two normals, and each component goes to the ends of
// its own edge.
inline void AdjCrossing(const double* points, const EdgeCrossing& crossing, const Vec2& adj_point,
                        Vec2 adj_vertex[4]) {
  Vec2 normal[2];
  for (int k = 0; k < 2; ++k) {
    const Vec2 e =
        PointAt(points, crossing.vertex[2 * k + 1]) - PointAt(points, crossing.vertex[2 * k]);
    normal[k] = {-e.y, e.x};
  }
  const double det = Cross(normal[0], normal[1]);
  const double share[2] = {Cross(adj_point, normal[1]) / det, Cross(normal[0], adj_point) / det};
  for (int k = 0; k < 4; ++k) {
    const double t = crossing.t[k / 2];
    adj_vertex[k] = (share[k / 2] * (k % 2 == 0 ? 1 - t : t)) * normal[k / 2];
  }
}

struct SilhouetteEdges {
  std::vector<SilhouettePiece> pieces;
  std::vector<EdgeCrossing> crossings;
};

// Finds the border of the silhouette, holes included. The candidates are the boundary edges of the
// mesh and the hinges whose faces overlap in the image. They are cut where they cross, and a part
// is kept when exactly one of its sides is covered. image_points: finite, [px], shape [2, V].
SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Eigen::Matrix2Xd& image_points);

struct SoftSilhouetteOptions {
  double half_width = 1.0;  // of the ramp around the border [px], > 0
};

// A pixel on the ramp and the derivatives of its coverage by the image points of at most four
// vertices.
struct RampPixel {
  int pixel;         // row · width + column
  int num_vertices;  // 1, 2, or 4 (the nearest point is a crossing of two edges)
  int vertex[4];
  Eigen::Vector2d d_image[4];  // ∂coverage/∂(column, row) of the vertex [1/px]
};

struct SoftSilhouette {
  int width = 0;
  int height = 0;
  Eigen::VectorXd coverage;     // row-major, shape [height · width], in [0, 1]
  std::vector<RampPixel> ramp;  // ascending by pixel
};

// The differentiable silhouette [MODEL, M48]. With φ the distance of a pixel centre to the border
// of the union of ALL projected triangles (positive inside), coverage = u²(3 − 2u) with u = ½(1 +
// φ/half_width) clamped to [0, 1]. It is C1 in φ, ½ on the border, and unbiased in area along a
// straight edge. The derivative is exact wherever the nearest border point is unique; the coverage
// jumps where a slit between two folds closes. x [m], shape [3V]. Returns false when x is not
// finite or not in front of the camera.
bool RenderSoft(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                const SoftSilhouetteOptions& options, SoftSilhouette* silhouette);

}  // namespace drape
