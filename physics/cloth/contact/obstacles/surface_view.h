// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/util/math/host_device.h"

namespace drape {

// Distances from points and segments, for host and device.

struct SymmetricMatrix {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
};
DRAPE_INLINE double Trace(const SymmetricMatrix& m) { return m.xx + m.yy + m.zz; }
DRAPE_INLINE Vec3<double> operator*(const SymmetricMatrix& m, const Vec3<double>& a) {
  return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
          m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
// m += s·a·aᵀ.
DRAPE_INLINE void AddSquare(double s, const Vec3<double>& a, SymmetricMatrix& m) {
  m.xx += s * a.x * a.x;
  m.xy += s * a.x * a.y;
  m.xz += s * a.x * a.z;
  m.yy += s * a.y * a.y;
  m.yz += s * a.y * a.z;
  m.zz += s * a.z * a.z;
}
DRAPE_INLINE void AddScaled(double s, const SymmetricMatrix& a, SymmetricMatrix& m) {
  m.xx += s * a.xx;
  m.xy += s * a.xy;
  m.xz += s * a.xz;
  m.yy += s * a.yy;
  m.yz += s * a.yz;
  m.zz += s * a.zz;
}
// block += s·m; s·a·bᵀ. Blocks are of 3 × 3, row by row.
DRAPE_INLINE void AddToBlock(double s, const SymmetricMatrix& m, double (&block)[9]) {
  const double rows[9] = {m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz};
  for (int n = 0; n < 9; ++n) block[n] += s * rows[n];
}
DRAPE_INLINE void AddToBlock(double s, const Vec3<double>& a, const Vec3<double>& b,
                             double (&block)[9]) {
  const double rows[3] = {s * a.x, s * a.y, s * a.z}, columns[3] = {b.x, b.y, b.z};
  for (int n = 0; n < 9; ++n) block[n] += rows[n / 3] * columns[n % 3];
}

// Whether m is negative semidefinite to rounding, and not 0.
DRAPE_HD inline bool IsNegativeSemidefinite(const SymmetricMatrix& m) {
  constexpr double kRounding = 1e-10;
  const double size = -Trace(m), more = kRounding * size;
  if (!(size > 0.0)) return false;
  const double first = more - m.xx;
  if (!(first > 0.0)) return false;
  const double second = more - m.yy - m.xy * m.xy / first, mixed = -m.yz - m.xy * m.xz / first;
  if (!(second > 0.0)) return false;
  return more - m.zz - m.xz * m.xz / first - mixed * mixed / second > 0.0;
}

// ObstacleDistance as plain data.
struct SolidDistance {
  double value = 0.0;
  Vec3<double> normal{0.0, 0.0, 0.0};
  SymmetricMatrix curvature;
  SymmetricMatrix blend = {};  // the negative semidefinite part of it that H has [MODEL, M60]
};

// From a point, less a radius. `fixed`: a direction of unit length in which that point follows x,
// or zero.
DRAPE_HD inline SolidDistance AwayFrom(const Vec3<double>& offset, double radius,
                                       const Vec3<double>& fixed) {
  const double length = std::sqrt(Dot(offset, offset));
  SolidDistance distance;
  distance.value = length - radius;
  distance.normal = {0.0, 0.0, 1.0};
  if (!(length > 0.0)) return distance;
  distance.normal = (1.0 / length) * offset;
  distance.curvature.xx = distance.curvature.yy = distance.curvature.zz = 1.0 / length;
  AddSquare(-1.0 / length, fixed, distance.curvature);
  AddSquare(-1.0 / length, distance.normal, distance.curvature);
  return distance;
}

// From the points within `radius` of a segment.
DRAPE_HD inline SolidDistance DistanceToSegment(const Vec3<double>& from, const Vec3<double>& to,
                                                double radius, const Vec3<double>& x) {
  const Vec3<double> axis = to - from, offset = x - from, none{0.0, 0.0, 0.0};
  const double square = Dot(axis, axis);
  const double along = square > 0.0 ? Dot(axis, offset) / square : 0.0;
  if (along <= 0.0) return AwayFrom(offset, radius, none);
  if (along >= 1.0) return AwayFrom(x - to, radius, none);
  return AwayFrom(offset - along * axis, radius, (1.0 / std::sqrt(square)) * axis);
}

// A closed triangle mesh as plain data, for host and device: a view of a SurfaceObstacle or of its
// copy on a device. V vertices, T triangles; a part of a triangle is itself, one of its edges or
// one of its corners.
struct SurfaceView {
  double reach = 0.0, cell = 1.0;  // up to which the distance is known; of the grid [m]
  Vec3<double> origin{0.0, 0.0, 0.0};
  int cells[3] = {};
  bool is_convex = false;
  const double* x = nullptr;              // [3V] [m]
  const int* corner = nullptr;            // [3T]
  const int* neighbour = nullptr;         // [3T], over the edge opposite each corner
  const int* counted = nullptr;           // [T], bits of CountedPart
  const double* centre = nullptr;         // [3T], of a ball around each triangle [m]
  const double* radius = nullptr;         // [T] [m]
  const double* face_normal = nullptr;    // [3T], of unit length
  const double* corner_normal = nullptr;  // [3V], by angle
  // Triangles within reach of each cell.
  const int* cell_start = nullptr;
  const int* cell_triangle = nullptr;
};

// The parts whose distances are summed with that of the triangle [MODEL, M60], each of one triangle
// alone: the edge opposite corner k is bit k, corner k is bit 3 + k.
DRAPE_HD constexpr int CountedEdge(int k) { return 1 << k; }
DRAPE_HD constexpr int CountedCorner(int k) { return 8 << k; }

// Distances are blended over this length [m], and without weight so many of them off.
constexpr double kSurfaceBlend = 3e-4, kSurfaceFaded = 20.0;

// The nearest point as weights of the three corners of a triangle; triangle −1: none in reach.
struct SurfacePoint {
  int triangle = -1;
  Vec3<double> weights{0.0, 0.0, 0.0};
};

DRAPE_HD inline Vec3<double> CornerPlace(const SurfaceView& surface, int triangle, int k) {
  return LoadVec3(surface.x, surface.corner[3 * triangle + k]);
}
DRAPE_HD inline Vec3<double> Place(const SurfaceView& surface, const SurfacePoint& point) {
  return point.weights.x * CornerPlace(surface, point.triangle, 0) +
         point.weights.y * CornerPlace(surface, point.triangle, 1) +
         point.weights.z * CornerPlace(surface, point.triangle, 2);
}

// The triangles within reach of the cell of x, as a range of cell_triangle.
struct TriangleRange {
  int begin = 0, end = 0;
};
DRAPE_HD inline TriangleRange TrianglesNear(const SurfaceView& surface, const Vec3<double>& x) {
  const Vec3<double> from = x - surface.origin;
  const double place[3] = {from.x / surface.cell, from.y / surface.cell, from.z / surface.cell};
  int cell = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(place[k] >= 0.0 && place[k] < surface.cells[k])) return {};
    cell = cell * surface.cells[k] + static_cast<int>(place[k]);
  }
  return {surface.cell_start[cell], surface.cell_start[cell + 1]};
}

// Whether the ball around triangle t is not within `distance` of x.
DRAPE_HD inline bool IsBeyond(const SurfaceView& surface, int t, const Vec3<double>& x,
                              double distance) {
  const Vec3<double> offset = x - LoadVec3(surface.centre, t);
  const double most = distance + surface.radius[t];
  return Dot(offset, offset) > most * most;
}

DRAPE_HD inline SurfacePoint NearestPoint(const SurfaceView& surface, int t,
                                          const Vec3<double>& x) {
  return {t, NearestWeights(x, CornerPlace(surface, t, 0), CornerPlace(surface, t, 1),
                            CornerPlace(surface, t, 2))};
}

DRAPE_HD inline SurfacePoint FindNearest(const SurfaceView& surface, const Vec3<double>& x) {
  SurfacePoint nearest;
  double least = surface.reach;
  const TriangleRange near = TrianglesNear(surface, x);
  for (int i = near.begin; i < near.end; ++i) {
    const int t = surface.cell_triangle[i];
    if (IsBeyond(surface, t, x, least)) continue;
    const SurfacePoint other = NearestPoint(surface, t, x);
    const Vec3<double> offset = x - Place(surface, other);
    const double length = std::sqrt(Dot(offset, offset));
    if (length >= least) continue;
    least = length;
    nearest = other;
  }
  return nearest;
}

// The normal at a nearest point: its triangle's, edge's or corner's [Baerentzen 2005].
DRAPE_HD inline Vec3<double> PseudoNormal(const SurfaceView& surface, const SurfacePoint& point) {
  const double weights[3] = {point.weights.x, point.weights.y, point.weights.z};
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 1.0)
      return LoadVec3(surface.corner_normal, surface.corner[3 * point.triangle + k]);
  const Vec3<double> normal = LoadVec3(surface.face_normal, point.triangle);
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 0.0)
      return normal + LoadVec3(surface.face_normal, surface.neighbour[3 * point.triangle + k]);
  return normal;
}

// From a point of a triangle that follows x: on its plane, along an edge, or not at all.
DRAPE_HD inline SolidDistance DistanceToPoint(const SurfaceView& surface, const SurfacePoint& point,
                                              const Vec3<double>& x) {
  const Vec3<double> offset = x - Place(surface, point), none{0.0, 0.0, 0.0};
  const double weights[3] = {point.weights.x, point.weights.y, point.weights.z};
  int zeros = 0, zero = 0;
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 0.0) {
      ++zeros;
      zero = k;
    }
  if (zeros == 2) return AwayFrom(offset, 0.0, none);
  if (zeros == 1) {
    const Vec3<double> edge = CornerPlace(surface, point.triangle, (zero + 2) % 3) -
                              CornerPlace(surface, point.triangle, (zero + 1) % 3);
    return AwayFrom(offset, 0.0, (1.0 / std::sqrt(Dot(edge, edge))) * edge);
  }
  SolidDistance distance = AwayFrom(offset, 0.0, none);
  distance.curvature = {};
  return distance;
}

// Calls visit(sign, distance) for the parts whose distance is less than `most`.
template <class Visit>
DRAPE_HD void ForEachPart(const SurfaceView& surface, const Vec3<double>& x, double most,
                          const Visit& visit) {
  const TriangleRange near = TrianglesNear(surface, x);
  for (int i = near.begin; i < near.end; ++i) {
    const int t = surface.cell_triangle[i];
    if (IsBeyond(surface, t, x, most)) continue;
    const SolidDistance of_face = DistanceToPoint(surface, NearestPoint(surface, t, x), x);
    if (of_face.value > most) continue;
    visit(1.0, of_face);
    const int counted = surface.counted[t];
    for (int k = 0; k < 3; ++k) {
      if (counted & CountedEdge(k)) {
        const SolidDistance of_edge = DistanceToSegment(
            CornerPlace(surface, t, (k + 1) % 3), CornerPlace(surface, t, (k + 2) % 3), 0.0, x);
        if (of_edge.value <= most) visit(-1.0, of_edge);
      }
      if (counted & CountedCorner(k)) {
        const SolidDistance of_corner =
            AwayFrom(x - CornerPlace(surface, t, k), 0.0, {0.0, 0.0, 0.0});
        if (of_corner.value <= most) visit(1.0, of_corner);
      }
    }
  }
}

// Weighted sums over the parts of 1, ∇d, ∇d·∇dᵀ and ∇²d; for the change of the blend with x, w
// held, of ∇d·∇dᵀ times ∇d·w, and of the derivative of ∇d·∇dᵀ·w, row by row.
struct PartSums {
  double weight = 0.0;
  Vec3<double> normal{0.0, 0.0, 0.0};
  SymmetricMatrix square = {}, bend = {}, square_along = {};
  double of_square[9] = {};
};
// w: null where no change is asked for.
DRAPE_HD inline PartSums SumParts(const SurfaceView& surface, const Vec3<double>& x, double least,
                                  const Vec3<double>* w) {
  PartSums sums;
  ForEachPart(surface, x, least + kSurfaceFaded * kSurfaceBlend,
              [&](double sign, const SolidDistance& d) {
                const double weight = sign * std::exp(-(d.value - least) / kSurfaceBlend);
                sums.weight += weight;
                sums.normal = sums.normal + weight * d.normal;
                AddSquare(weight, d.normal, sums.square);
                AddScaled(weight, d.curvature, sums.bend);
                if (w == nullptr) return;
                const double along = weight * Dot(d.normal, *w);
                AddSquare(along, d.normal, sums.square_along);
                AddToBlock(along, d.curvature, sums.of_square);
                AddToBlock(weight, d.normal, d.curvature * *w, sums.of_square);
              });
  return sums;
}

// Adds the derivative of distance.blend·w by x with w held.
DRAPE_HD inline void AddBlendChange(const PartSums& sums, const SolidDistance& distance,
                                    const Vec3<double>& w, double (&change)[9]) {
  const double k = 1.0 / kSurfaceBlend, share = 1.0 / sums.weight;
  AddToBlock(k * Dot(distance.normal, w), distance.curvature, change);
  AddToBlock(k, distance.normal, distance.curvature * w, change);
  AddToBlock(-k * k * share, sums.square * w, distance.normal, change);
  AddToBlock(k * k * share, sums.square_along, change);
  for (int n = 0; n < 9; ++n) change[n] -= k * share * sums.of_square[n];
}

// The distance and, unless change is null, the derivative of blend·w by x, w held, row by row.
DRAPE_HD inline SolidDistance MeasureSurface(const SurfaceView& surface, const Vec3<double>& x,
                                             const Vec3<double>& w, double (*change)[9]) {
  SolidDistance distance;
  distance.value = surface.reach;
  const SurfacePoint nearest = FindNearest(surface, x);
  if (nearest.triangle < 0) return distance;
  const SolidDistance of_nearest = DistanceToPoint(surface, nearest, x);
  const double least = of_nearest.value;
  if (!(least > 0.0)) {
    distance.value = 0.0;
    distance.normal = LoadVec3(surface.face_normal, nearest.triangle);
    return distance;
  }
  if (Dot(of_nearest.normal, PseudoNormal(surface, nearest)) < 0.0) {
    distance.value = -least;
    distance.normal = -1.0 * of_nearest.normal;
    return distance;
  }
  const PartSums sums = SumParts(surface, x, least, change == nullptr ? nullptr : &w);
  // Less than the nearest part alone: it is in the middle of a ring [MODEL, M60].
  if (!(sums.weight >= 1.0)) return of_nearest;
  const double share = 1.0 / sums.weight;
  distance.value = least - kSurfaceBlend * std::log(sums.weight);
  distance.normal = share * sums.normal;
  SymmetricMatrix blend;
  AddSquare(1.0 / kSurfaceBlend, distance.normal, blend);
  AddScaled(-share / kSurfaceBlend, sums.square, blend);
  AddScaled(share, sums.bend, distance.curvature);
  AddScaled(1.0, blend, distance.curvature);
  if (!IsNegativeSemidefinite(blend)) return distance;
  distance.blend = blend;
  if (change != nullptr) AddBlendChange(sums, distance, w, *change);
  return distance;
}

DRAPE_HD inline SolidDistance DistanceTo(const SurfaceView& surface, const Vec3<double>& x) {
  return MeasureSurface(surface, x, {0.0, 0.0, 0.0}, nullptr);
}
// block += scale·∂(blend·w)/∂x with w held.
DRAPE_HD inline void AddBlendChange(const SurfaceView& surface, const Vec3<double>& x,
                                    const Vec3<double>& w, double scale, double (&block)[9]) {
  double change[9] = {};
  MeasureSurface(surface, x, w, &change);
  for (int n = 0; n < 9; ++n) block[n] += scale * change[n];
}

}  // namespace drape
