// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/surface_net.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace drape {
namespace {

using Eigen::Vector3d;
using Distance = std::function<double(const Vector3d&)>;
using Triangle = std::array<int, 3>;

constexpr int kRelaxations = 25, kFinalProjections = 3;
constexpr double kDelaunayTolerance = 1e-6;  // [rad]

// The values at the corners of the cubes. The planes of corners are at odd multiples of half a cell
// from x = 0, so that no quadrilateral lies across the plane of symmetry.
class Lattice {
 public:
  Lattice(const Distance& distance, const SurfaceNetBox& box, double cell)
      : cell_(cell), first_(-Half(box.half_x), -Half(box.half_y), box.bottom) {
    size_ = {1 + static_cast<int>(std::lround(-2 * first_.x() / cell)),
             1 + static_cast<int>(std::lround(-2 * first_.y() / cell)),
             2 + static_cast<int>(std::ceil((box.top - box.bottom) / cell))};
    value_.resize(size_t(size_[0]) * size_[1] * size_[2]);
    for (int k = 0; k < size_[2]; ++k)
      for (int j = 0; j < size_[1]; ++j)
        for (int i = 0; i < size_[0]; ++i) value_[Index({i, j, k})] = distance(Place({i, j, k}));
  }

  using Corner = std::array<int, 3>;
  const std::array<int, 3>& size() const { return size_; }
  size_t Index(const Corner& c) const { return (size_t(c[2]) * size_[1] + c[1]) * size_[0] + c[0]; }
  Vector3d Place(const Corner& c) const { return first_ + cell_ * Vector3d(c[0], c[1], c[2]); }
  double At(const Corner& c) const { return value_[Index(c)]; }
  bool OnBorder(const Corner& c) const {
    for (int d = 0; d < 3; ++d)
      if (c[d] == 0 || c[d] == size_[d] - 1) return true;
    return false;
  }

 private:
  double Half(double half) const { return (std::ceil(half / cell_) + .5) * cell_; }

  double cell_;
  Vector3d first_;
  std::array<int, 3> size_;
  std::vector<double> value_;
};

Lattice::Corner Next(Lattice::Corner corner, int axis, int steps = 1) {
  corner[axis] += steps;
  return corner;
}

class NetBuilder {
 public:
  explicit NetBuilder(const Lattice& lattice) : lattice_(lattice) {}

  // Adds the quadrilateral of vertices about an edge of the lattice that the surface crosses.
  void AddEdge(const Lattice::Corner& corner, int axis) {
    const bool inside = lattice_.At(corner) < 0;
    if (inside == (lattice_.At(Next(corner, axis)) < 0)) return;
    CHECK(!lattice_.OnBorder(corner)) << "the surface leaves the box";
    std::array<int, 4> q;
    for (int k = 0; k < 4; ++k) {
      constexpr int kAround[] = {3, 2, 0, 1};  // sides, counter-clockwise
      const int side = kAround[k];
      const auto cube =
          Next(Next(corner, (axis + 1) % 3, -(side & 1)), (axis + 2) % 3, -(side >> 1));
      q[k] = VerticesIn(cube)[4 * axis + side];
    }
    if (!inside) std::swap(q[1], q[3]);
    if ((points[q[0]] - points[q[2]]).norm() > (points[q[1]] - points[q[3]]).norm())
      std::rotate(q.begin(), q.begin() + 1, q.end());
    triangles.push_back({q[0], q[1], q[2]});
    triangles.push_back({q[0], q[2], q[3]});
  }

  std::vector<Vector3d> points;
  std::vector<Triangle> triangles;

 private:
  // By the number of an edge, 4 · axis + side: the vertex of the sheet that crosses it.
  using Vertices = std::array<int, 12>;

  // Corner c of a cube has the offsets of the bits of c along x, y, z.
  static Lattice::Corner CornerPlace(const Lattice::Corner& cube, int c) {
    return {cube[0] + (c & 1), cube[1] + (c >> 1 & 1), cube[2] + (c >> 2)};
  }
  static int EdgeNumber(int a, int b) {  // of neighbouring corners
    const int axis = (a ^ b) >> 1, low = a & b;
    return 4 * axis + (low >> (axis + 1) % 3 & 1) + 2 * (low >> (axis + 2) % 3 & 1);
  }

  // Each sheet of the surface in a cube has a vertex, the mean of the places where it crosses edges
  // [Nielson 2004].
  const Vertices& VerticesIn(const Lattice::Corner& cube) {
    const auto [it, is_new] = vertices_.try_emplace(cube);
    Vertices& sheet = it->second;
    if (!is_new) return sheet;
    LinkSheets(cube, &sheet);
    Vertices vertex;
    vertex.fill(-1);
    std::array<int, 12> count{};
    for (int a = 0; a < 8; ++a) {
      for (const int b : {a | 1, a | 2, a | 4}) {
        if (a == b) continue;
        const auto from = CornerPlace(cube, a), to = CornerPlace(cube, b);
        const double fa = lattice_.At(from), fb = lattice_.At(to);
        if ((fa < 0) == (fb < 0)) continue;
        const int s = sheet[EdgeNumber(a, b)];
        if (vertex[s] < 0) {
          vertex[s] = static_cast<int>(points.size());
          points.push_back(Vector3d::Zero());
        }
        const Vector3d p = lattice_.Place(from);
        points[vertex[s]] += p + fa / (fa - fb) * (lattice_.Place(to) - p);
        ++count[s];
      }
    }
    for (int s = 0; s < 12; ++s)
      if (vertex[s] >= 0) points[vertex[s]] /= count[s];
    for (int& s : sheet) s = vertex[s];
    return sheet;
  }

  // Numbers the sheets: crossed edges of one face of the cube belong together, of a face with four
  // of them the two at each inner corner.
  void LinkSheets(const Lattice::Corner& cube, Vertices* sheet) const {
    for (int e = 0; e < 12; ++e) (*sheet)[e] = e;
    const auto link = [sheet](int e, int f) {
      std::replace(sheet->begin(), sheet->end(), int((*sheet)[f]), int((*sheet)[e]));
    };
    for (int d = 0; d < 3; ++d) {
      for (const int base : {0, 1 << d}) {
        const int u = 1 << (d + 1) % 3, v = 1 << (d + 2) % 3;
        const int corner[] = {base, base | u, base | u | v, base | v};
        std::vector<int> crossed;
        for (int k = 0; k < 4; ++k)
          if (Inside(cube, corner[k]) != Inside(cube, corner[(k + 1) % 4]))
            crossed.push_back(EdgeNumber(corner[k], corner[(k + 1) % 4]));
        if (crossed.size() == 2) link(crossed[0], crossed[1]);
        for (int k = 0; k < 4 && crossed.size() == 4; ++k)
          if (Inside(cube, corner[k])) link(crossed[k], crossed[(k + 3) % 4]);
      }
    }
  }
  bool Inside(const Lattice::Corner& cube, int corner) const {
    return lattice_.At(CornerPlace(cube, corner)) < 0;
  }

  const Lattice& lattice_;
  std::map<Lattice::Corner, Vertices> vertices_;
};

Vector3d Gradient(const Distance& distance, const Vector3d& p) {
  constexpr double kStep = 1e-5;  // [m]
  Vector3d gradient;
  for (int d = 0; d < 3; ++d) {
    const Vector3d step = kStep * Vector3d::Unit(d);
    gradient[d] = (distance(p + step) - distance(p - step)) / (2 * kStep);
  }
  return gradient;
}

// One step of Newton's method towards the surface.
Vector3d Projected(const Distance& distance, const Vector3d& p) {
  const Vector3d gradient = Gradient(distance, p);
  return p - distance(p) / gradient.squaredNorm() * gradient;
}

// Moves each vertex along the surface to the mean of the centroids of its faces, weighted by area.
void Relax(const Distance& distance, const std::vector<Triangle>& triangles,
           std::vector<Vector3d>* points) {
  std::vector<Vector3d> sum(points->size(), Vector3d::Zero());
  std::vector<double> weight(points->size(), 0);
  for (const Triangle& t : triangles) {
    const Vector3d &a = (*points)[t[0]], &b = (*points)[t[1]], &c = (*points)[t[2]];
    const double area = (b - a).cross(c - a).norm();
    for (const int i : t) {
      sum[i] += area * (a + b + c) / 3;
      weight[i] += area;
    }
  }
  for (size_t i = 0; i < points->size(); ++i)
    (*points)[i] = Projected(distance, sum[i] / weight[i]);
}

struct Flip {
  double excess;  // of the two angles opposite the edge over 180° [rad]
  int first, second;
  int a, b, c, d;  // edge a–b of the faces abc and bad becomes c–d
};

double AngleAt(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  return std::atan2((a - p).cross(b - p).norm(), (a - p).dot(b - p));
}

using EdgeFaces = std::map<std::pair<int, int>, std::pair<int, int>>;  // directed: face, opposite

EdgeFaces DirectedEdges(const std::vector<Triangle>& triangles) {
  EdgeFaces edges;
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    const Triangle& t = triangles[f];
    for (int k = 0; k < 3; ++k) edges[{t[k], t[(k + 1) % 3]}] = {f, t[(k + 2) % 3]};
  }
  return edges;
}

// Edges that violate the Delaunay criterion, the worst first.
std::vector<Flip> FindFlips(const EdgeFaces& edges, const std::vector<Vector3d>& points) {
  std::vector<Flip> flips;
  for (const auto& [edge, face] : edges) {
    const auto [a, b] = edge;
    const auto twin = edges.find({b, a});
    if (a > b || twin == edges.end()) continue;
    const int c = face.second, d = twin->second.second;
    const double excess = AngleAt(points[c], points[a], points[b]) +
                          AngleAt(points[d], points[a], points[b]) - EIGEN_PI;
    const bool exists = edges.count({c, d}) || edges.count({d, c});
    if (excess > kDelaunayTolerance && !exists)
      flips.push_back({excess, face.first, twin->second.first, a, b, c, d});
  }
  std::sort(flips.begin(), flips.end(),
            [](const Flip& a, const Flip& b) { return a.excess > b.excess; });
  return flips;
}

void FlipEdges(const std::vector<Vector3d>& points, std::vector<Triangle>* triangles) {
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<bool> used(triangles->size(), false);
    for (const Flip& flip : FindFlips(DirectedEdges(*triangles), points)) {
      if (used[flip.first] || used[flip.second]) continue;
      used[flip.first] = used[flip.second] = true;
      (*triangles)[flip.first] = {flip.c, flip.a, flip.d};
      (*triangles)[flip.second] = {flip.d, flip.b, flip.c};
    }
  }
}

}  // namespace

ObjSurface MakeSurfaceNet(const Distance& distance, const SurfaceNetBox& box, double cell) {
  const Lattice lattice(distance, box, cell);
  NetBuilder net(lattice);
  const auto& size = lattice.size();
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        for (int axis = 0; axis < 3; ++axis)
          if (const Lattice::Corner c = {i, j, k}; c[axis] + 1 < size[axis]) net.AddEdge(c, axis);
  for (int round = 0; round < kRelaxations; ++round) {
    Relax(distance, net.triangles, &net.points);
    FlipEdges(net.points, &net.triangles);
  }
  for (int round = 0; round < kFinalProjections; ++round)
    for (Vector3d& p : net.points) p = Projected(distance, p);
  ObjSurface surface{Eigen::VectorXd(3 * net.points.size()), net.triangles};
  for (size_t i = 0; i < net.points.size(); ++i) surface.x.segment<3>(3 * i) = net.points[i];
  return surface;
}

}  // namespace drape
