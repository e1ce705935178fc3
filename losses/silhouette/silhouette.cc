// SPDX-License-Identifier: Apache-2.0
#include "losses/silhouette/silhouette.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace drape {
namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;

// The elementary operations of the soft silhouette [MODEL, M48] on edges, crossings, pieces of the
// border and pixels. `points`: the projected vertices [px], shape [2, V].

constexpr double kBorderProbe = 1e-6;  // [px] from an edge: where its sides are probed
constexpr double kOnBorder = 1e-9;     // [px] distance below which the offset has no direction

// The side of the edge i→j of the projected mesh on which the point lies: twice the signed area of
// the triangle (i, j, point) [px²]. It is exactly antisymmetric in (i, j), so that two triangles
// that share an edge leave no gap between them.
double EdgeSide(const Matrix2Xd& points, int i, int j, const Vector2d& p) {
  const double sign = i < j ? 1 : -1;
  const Vector2d a = points.col(std::min(i, j)), b = points.col(std::max(i, j));
  return sign * Determinant(b - a, p - a);
}

// Returns whether the closed projected triangle of three vertices contains the point, whichever
// face is seen. A triangle of zero area contains nothing.
bool Covers(const Matrix2Xd& points, const int* triangle, const Vector2d& p) {
  const int a = triangle[0], b = triangle[1], c = triangle[2];
  const double ab = EdgeSide(points, a, b, p);
  const double bc = EdgeSide(points, b, c, p);
  const double ca = EdgeSide(points, c, a, p);
  const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  return inside && EdgeSide(points, a, b, points.col(c)) != 0;
}

// The pixels first … last of [0, size) that lie in [min, max]; the range is empty when first >
// last.
struct PixelRange {
  int first, last;
};
PixelRange PixelsIn(double min, double max, int size) {
  const double end = size;
  return {static_cast<int>(std::ceil(std::fmin(std::fmax(min, 0.0), end))),
          static_cast<int>(std::floor(std::fmin(std::fmax(max, -1.0), end - 1.0)))};
}

// Returns whether the two faces of a hinge overlap in the image.
bool FoldsOver(const Matrix2Xd& points, const Hinge& hinge) {
  const int* v = hinge.vertex;
  return EdgeSide(points, v[0], v[1], points.col(v[2])) *
             EdgeSide(points, v[0], v[1], points.col(v[3])) >=
         0;
}

bool ShareVertex(const int l[2], const int r[2]) {
  return l[0] == r[0] || l[0] == r[1] || l[1] == r[0] || l[1] == r[1];
}

// Computes the positions t of the crossing on the edges l and r. Returns false when they do not
// cross inside both.
bool Intersect(const Matrix2Xd& points, const int l[2], const int r[2], double t[2]) {
  const Vector2d l0 = points.col(l[0]), r0 = points.col(r[0]);
  const Vector2d e = points.col(l[1]) - l0, f = points.col(r[1]) - r0;
  const Vector2d offset = r0 - l0;
  const double det = Determinant(e, f);
  if (det == 0) return false;
  t[0] = Determinant(offset, f) / det;
  t[1] = Determinant(offset, e) / det;
  return t[0] > 0 && t[0] < 1 && t[1] > 0 && t[1] < 1;
}

// Returns whether a part of an edge is a piece of the border, that is, whether exactly one of its
// sides is covered, and sets its inward normal. is_covered(point) → bool.
template <class IsCovered>
bool FindInward(const Matrix2Xd& points, const IsCovered& is_covered, SilhouettePiece* part) {
  const Vector2d a = points.col(part->vertex[0]), e = points.col(part->vertex[1]) - a;
  const double length = e.norm();
  const Vector2d normal{-e.y() / length, e.x() / length};
  const Vector2d middle = a + (0.5 * (part->t[0] + part->t[1])) * e;
  const bool plus = is_covered(middle + kBorderProbe * normal);
  const bool minus = is_covered(middle - kBorderProbe * normal);
  part->inward = plus ? normal : Vector2d(-normal);
  return plus != minus;
}

// The point of a piece that is nearest to a pixel.
struct PieceContact {
  double distance;  // [px]
  double t;         // position on the edge of the piece
  int end;          // 0 or 1: this end of the piece; −1: between the ends
};
PieceContact NearestOnPiece(const Matrix2Xd& points, const SilhouettePiece& piece,
                            const Vector2d& pixel) {
  const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
  double t = (pixel - a).dot(e) / e.dot(e);
  const int end = t <= piece.t[0] ? 0 : t >= piece.t[1] ? 1 : -1;
  if (end >= 0) t = piece.t[end];
  const Vector2d offset = pixel - a - t * e;
  return {offset.norm(), t, end};
}

// The columns and rows within `reach` [px] of a piece, not yet clipped to the image.
struct PieceBox {
  Vector2d min, max;
};
PieceBox BoundingBox(const Matrix2Xd& points, const SilhouettePiece& piece, double reach) {
  const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
  const Vector2d p = a + piece.t[0] * e, q = a + piece.t[1] * e;
  return {p.cwiseMin(q).array() - reach, p.cwiseMax(q).array() + reach};
}

// The coverage at a distance from the border [px], and its derivative by the signed distance [1/px]
// [MODEL, M48].
struct SoftRamp {
  double coverage, slope;
};
SoftRamp RampAt(double distance, bool inside, double half_width) {
  const double u = 0.5 * (1 + (inside ? 1.0 : -1.0) * distance / half_width);
  return {u * u * (3 - 2 * u), 3 * u * (1 - u) / half_width};
}

// ∂coverage/∂(point of contact) [1/px], by the envelope theorem with its position on the edge held.
Vector2d CoverageByPoint(const Matrix2Xd& points, const SilhouettePiece& piece,
                         const PieceContact& contact, const Vector2d& pixel, bool inside,
                         double slope) {
  if (contact.distance < kOnBorder) return -slope * piece.inward;
  const Vector2d a = points.col(piece.vertex[0]), e = points.col(piece.vertex[1]) - a;
  const Vector2d offset = pixel - a - contact.t * e;
  const Vector2d inward = ((inside ? 1.0 : -1.0) / contact.distance) * offset;
  return -slope * inward;
}

// A crossing X lies on both edges: n·δX = (1 − t) n·δa + t n·δb for the normal n of each. The
// adjoint of X is written in the basis of the two normals, and each component goes to the ends of
// its own edge.
void AdjCrossing(const Matrix2Xd& points, const EdgeCrossing& crossing, const Vector2d& adj_point,
                 Vector2d adj_vertex[4]) {
  Vector2d normal[2];
  for (int k = 0; k < 2; ++k) {
    const Vector2d e = points.col(crossing.vertex[2 * k + 1]) - points.col(crossing.vertex[2 * k]);
    normal[k] = {-e.y(), e.x()};
  }
  const double det = Determinant(normal[0], normal[1]);
  const double share[2] = {Determinant(adj_point, normal[1]) / det,
                           Determinant(normal[0], adj_point) / det};
  for (int k = 0; k < 4; ++k) {
    const double t = crossing.t[k / 2];
    adj_vertex[k] = (share[k / 2] * (k % 2 == 0 ? 1 - t : t)) * normal[k / 2];
  }
}

// The columns whose centres a projected triangle may cover in a row that meets its box: between the
// points of its edges there, and a little more than rounding errors.
PixelRange ColumnsNear(const Matrix2Xd& points, const int* triangle, int row, int width) {
  constexpr double kMargin = 1e-3, kFlat = 1e-3, kLongest = 1e6;  // [px]
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    const Vector2d a = points.col(triangle[k]), edge = points.col(triangle[(k + 1) % 3]) - a;
    if (std::abs(edge.y()) < kFlat || !(edge.cwiseAbs().maxCoeff() < kLongest)) {
      low = std::min({low, a.x(), a.x() + edge.x()});
      high = std::max({high, a.x(), a.x() + edge.x()});
    } else if (const double t = (row - a.y()) / edge.y(); t > -kMargin && t < 1 + kMargin) {
      low = std::min(low, a.x() + t * edge.x());
      high = std::max(high, a.x() + t * edge.x());
    }
  }
  return PixelsIn(low - kMargin, high + kMargin, width);
}

// Calls visit(pixel, centre) for pixels, row · width + column: those whose centres a projected
// triangle covers, and a few beside it.
template <class Visit>
void ForEachPixelNear(const Matrix2Xd& points, const int* triangle, int width, int height,
                      const Visit& visit) {
  const auto y = [&](int k) { return points(1, triangle[k]); };
  const PixelRange rows =
      PixelsIn(std::min({y(0), y(1), y(2)}), std::max({y(0), y(1), y(2)}), height);
  for (int row = rows.first; row <= rows.last; ++row) {
    const PixelRange columns = ColumnsNear(points, triangle, row, width);
    for (int col = columns.first; col <= columns.last; ++col)
      visit(size_t(row) * width + col, Vector2d(col, row));
  }
}

const int* Vertices(const Face& face) { return face.vertex; }
const int* Vertices(const std::array<int, 3>& triangle) { return triangle.data(); }

// Returns 1 for each pixel whose centre is covered by a triangle, row-major, shape [height, width].
// image_points: finite, [px], shape [2, V].
std::vector<uint8_t> CoveredPixels(const auto& triangles, const Matrix2Xd& image_points, int width,
                                   int height) {
  std::vector<uint8_t> covered(size_t(width) * height, 0);
  for (const auto& triangle : triangles) {
    const int* vertices = Vertices(triangle);
    ForEachPixelNear(image_points, vertices, width, height, [&](size_t pixel, const Vector2d& p) {
      if (!covered[pixel] && Covers(image_points, vertices, p)) covered[pixel] = 1;
    });
  }
  return covered;
}

// The fraction of the supersample² samples of each pixel that triangles cover.
GrayImage RasterizeTriangles(const auto& triangles, const Eigen::VectorXd& x, const Camera& camera,
                             int supersample) {
  CHECK_GE(supersample, 1);
  const int n = supersample, fine_width = n * camera.width;
  Matrix2Xd points;
  CHECK(ProjectVertices(x, camera, &points)) << "positions not finite or behind the camera";
  points = ((points.array() + 0.5) * n - 0.5).matrix();
  const std::vector<uint8_t> covered =
      CoveredPixels(triangles, points, fine_width, n * camera.height);
  GrayImage image(camera.width, camera.height);
  const uint8_t* sample = covered.data();
  for (int row = 0; row < n * camera.height; ++row)
    for (int col = 0; col < camera.width; ++col)
      for (int k = 0; k < n; ++k) image.at(col, row / n) += *sample++;
  for (float& c : image.coverage) c /= static_cast<float>(n * n);
  return image;
}

// Sorts the triangles into square cells of the image, to find those that cover a point.
class TriangleGrid {
 public:
  TriangleGrid(const Mesh& mesh, const Matrix2Xd& points) : mesh_(mesh), points_(points) {
    origin_ = points.rowwise().minCoeff();
    const Vector2d extent = (points.rowwise().maxCoeff() - origin_).cwiseMax(1e-12);
    side_ = std::max(1, static_cast<int>(std::sqrt(mesh.num_faces())));
    per_pixel_ = extent.cwiseInverse() * side_;
    cells_.resize(size_t(side_) * side_);
    for (int f = 0; f < mesh.num_faces(); ++f) Insert(f);
  }

  bool IsCovered(const Vector2d& p) const {
    const Vector2d cell = (p - origin_).cwiseProduct(per_pixel_);
    if (!(cell.minCoeff() >= 0 && cell.maxCoeff() <= side_)) return false;
    for (int f : cells_[Index(Clamp(cell.x()), Clamp(cell.y()))]) {
      if (Covers(points_, mesh_.faces[f].vertex, p)) return true;
    }
    return false;
  }

 private:
  int Clamp(double cell) const { return std::clamp(static_cast<int>(cell), 0, side_ - 1); }
  size_t Index(int column, int row) const { return size_t(row) * side_ + column; }

  void Insert(int f) {
    const int* v = mesh_.faces[f].vertex;
    const auto a = points_.col(v[0]), b = points_.col(v[1]), c = points_.col(v[2]);
    const Vector2d min = (a.cwiseMin(b).cwiseMin(c) - origin_).cwiseProduct(per_pixel_);
    const Vector2d max = (a.cwiseMax(b).cwiseMax(c) - origin_).cwiseProduct(per_pixel_);
    for (int row = Clamp(min.y()); row <= Clamp(max.y()); ++row) {
      for (int col = Clamp(min.x()); col <= Clamp(max.x()); ++col) {
        cells_[Index(col, row)].push_back(f);
      }
    }
  }

  const Mesh& mesh_;
  const Matrix2Xd& points_;
  Vector2d origin_, per_pixel_;
  int side_;
  std::vector<std::vector<int>> cells_;
};

struct Candidate {
  int vertex[2];
  double min_column, max_column;
  std::vector<std::pair<double, int>> cuts;  // t, index of the crossing
};

// Returns the candidates sorted by min_column, for the sweep.
std::vector<Candidate> FindCandidates(const Mesh& mesh, const Matrix2Xd& points) {
  std::vector<Candidate> candidates;
  const auto add = [&](int a, int b) {
    const auto [min, max] = std::minmax(points(0, a), points(0, b));
    if (points.col(a) != points.col(b)) candidates.push_back({{a, b}, min, max, {}});
  };
  for (const auto& loop : mesh.boundary_loops) {
    for (size_t i = 0; i < loop.size(); ++i) add(loop[i], loop[(i + 1) % loop.size()]);
  }
  for (const Hinge& hinge : mesh.hinges) {
    if (FoldsOver(points, hinge)) add(hinge.vertex[0], hinge.vertex[1]);
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& l, const Candidate& r) { return l.min_column < r.min_column; });
  return candidates;
}

std::vector<EdgeCrossing> CutCandidates(const Matrix2Xd& points, std::vector<Candidate>* all) {
  std::vector<EdgeCrossing> crossings;
  for (size_t i = 0; i < all->size(); ++i) {
    Candidate& l = (*all)[i];
    for (size_t j = i + 1; j < all->size() && (*all)[j].min_column <= l.max_column; ++j) {
      Candidate& r = (*all)[j];
      double t[2];
      if (ShareVertex(l.vertex, r.vertex) || !Intersect(points, l.vertex, r.vertex, t)) continue;
      const int index = static_cast<int>(crossings.size());
      crossings.push_back({{l.vertex[0], l.vertex[1], r.vertex[0], r.vertex[1]}, {t[0], t[1]}});
      l.cuts.emplace_back(t[0], index);
      r.cuts.emplace_back(t[1], index);
    }
  }
  return crossings;
}

// Adds the parts of one candidate with cloth on one side only.
void KeepBorderParts(const Matrix2Xd& points, const TriangleGrid& grid, Candidate* candidate,
                     std::vector<SilhouettePiece>* pieces) {
  auto& cuts = candidate->cuts;
  cuts.emplace_back(0.0, -1);
  cuts.emplace_back(1.0, -1);
  std::sort(cuts.begin(), cuts.end());
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    SilhouettePiece part{{candidate->vertex[0], candidate->vertex[1]},
                         {cuts[i].first, cuts[i + 1].first},
                         {cuts[i].second, cuts[i + 1].second},
                         {}};
    const auto is_covered = [&](const Vector2d& p) { return grid.IsCovered(p); };
    if (FindInward(points, is_covered, &part)) pieces->push_back(part);
  }
}

// The border point nearest to a pixel.
struct BorderContact {
  PieceContact at;
  int piece = -1;
};

// The nearest contact of each pixel within `reach` [px] of the border.
std::vector<BorderContact> FindContacts(const Matrix2Xd& points, const SilhouetteEdges& edges,
                                        const Camera& camera, double reach) {
  std::vector<BorderContact> contacts(size_t(camera.width) * camera.height,
                                      BorderContact{{reach, 0, -1}, -1});
  for (size_t i = 0; i < edges.pieces.size(); ++i) {
    const SilhouettePiece& piece = edges.pieces[i];
    const PieceBox box = BoundingBox(points, piece, reach);
    const PixelRange rows = PixelsIn(box.min.y(), box.max.y(), camera.height);
    const PixelRange columns = PixelsIn(box.min.x(), box.max.x(), camera.width);
    for (int row = rows.first; row <= rows.last; ++row) {
      for (int col = columns.first; col <= columns.last; ++col) {
        const PieceContact at = NearestOnPiece(points, piece, {double(col), double(row)});
        BorderContact& best = contacts[size_t(row) * camera.width + col];
        if (at.distance < best.at.distance) best = {at, static_cast<int>(i)};
      }
    }
  }
  return contacts;
}

// Fills in the derivatives of the coverage by the vertices on which the contact depends.
void FillRamp(const Matrix2Xd& points, const SilhouetteEdges& edges, const BorderContact& contact,
              bool inside, double slope, const Vector2d& pixel, RampPixel* ramp) {
  const SilhouettePiece& piece = edges.pieces[contact.piece];
  const Vector2d d_point = CoverageByPoint(points, piece, contact.at, pixel, inside, slope);
  const int crossing = contact.at.end < 0 ? -1 : piece.crossing[contact.at.end];
  ramp->num_vertices = crossing >= 0 ? 4 : 2;
  const int* vertex = crossing >= 0 ? edges.crossings[crossing].vertex : piece.vertex;
  std::copy_n(vertex, ramp->num_vertices, ramp->vertex);
  if (crossing >= 0) {
    AdjCrossing(points, edges.crossings[crossing], d_point, ramp->d_image);
  } else {
    ramp->d_image[0] = (1 - contact.at.t) * d_point;
    ramp->d_image[1] = contact.at.t * d_point;
  }
}

// Where the ray of a pixel meets a face that covers it. The image shows a point of a face by its
// barycentric coordinates in the image, times the depth for a pinhole, which lie in [0, 1] also
// where the face is seen edgewise.
SurfaceHit HitFace(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                   const Matrix2Xd& points, int f, const Vector2d& pixel) {
  const int* v = mesh.faces[f].vertex;
  SurfaceHit hit;
  hit.face = f;
  Eigen::Vector3d depth;
  for (int k = 0; k < 3; ++k) {
    depth[k] = DepthOrigin(camera) - x[3 * v[k] + 2];
    hit.weight[k] = std::abs(EdgeSide(points, v[(k + 1) % 3], v[(k + 2) % 3], pixel));
  }
  if (camera.is_pinhole()) hit.weight.array() /= depth.array();
  hit.weight /= hit.weight.sum();
  hit.depth = hit.weight.dot(depth);
  return hit;
}

}  // namespace

GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample) {
  return RasterizeTriangles(mesh.faces, x, camera, supersample);
}

GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample) {
  return RasterizeTriangles(surface.triangles, surface.x, camera, supersample);
}

SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Matrix2Xd& image_points) {
  SilhouetteEdges edges;
  std::vector<Candidate> candidates = FindCandidates(mesh, image_points);
  edges.crossings = CutCandidates(image_points, &candidates);
  const TriangleGrid grid(mesh, image_points);
  for (Candidate& candidate : candidates) {
    KeepBorderParts(image_points, grid, &candidate, &edges.pieces);
  }
  return edges;
}

bool RenderSoft(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                const SoftSilhouetteOptions& options, SoftSilhouette* silhouette) {
  CHECK_GT(options.half_width, 0);
  Matrix2Xd points;
  if (!ProjectVertices(x, camera, &points)) return false;
  const SilhouetteEdges edges = FindSilhouetteEdges(mesh, points);
  const auto contacts = FindContacts(points, edges, camera, options.half_width);
  const auto covered = CoveredPixels(mesh.faces, points, camera.width, camera.height);
  silhouette->width = camera.width;
  silhouette->height = camera.height;
  silhouette->coverage.resize(covered.size());
  silhouette->ramp.clear();
  for (size_t i = 0; i < covered.size(); ++i) {
    const BorderContact& contact = contacts[i];
    silhouette->coverage[i] = covered[i];
    if (contact.piece < 0) continue;
    const SoftRamp at = RampAt(contact.at.distance, covered[i] != 0, options.half_width);
    silhouette->coverage[i] = at.coverage;
    RampPixel& ramp = silhouette->ramp.emplace_back();
    ramp.pixel = static_cast<int>(i);
    const Vector2d pixel{double(i % camera.width), double(i / camera.width)};
    FillRamp(points, edges, contact, covered[i] != 0, at.slope, pixel, &ramp);
  }
  return true;
}

bool FindVisible(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                 std::vector<SurfaceHit>* hits) {
  Matrix2Xd points;
  if (!ProjectVertices(x, camera, &points)) return false;
  hits->assign(size_t(camera.width) * camera.height, {});
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const int* vertices = mesh.faces[f].vertex;
    ForEachPixelNear(points, vertices, camera.width, camera.height,
                     [&](size_t pixel, const Vector2d& p) {
                       if (!Covers(points, vertices, p)) return;
                       const SurfaceHit hit = HitFace(mesh, x, camera, points, f, p);
                       if (hit.depth < (*hits)[pixel].depth) (*hits)[pixel] = hit;
                     });
  }
  return true;
}

}  // namespace drape
