// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/skeleton.h"

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

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Flesh Cone(const Vector3d& a, const Vector3d& b, double radius_a, double radius_b) {
  return {a, b, radius_a, radius_b};
}

Flesh Ellipsoid(const Vector3d& centre, const Vector3d& half_axes) {
  return {centre, centre, 0, 0, half_axes};
}

// Moves a point of the left side to the right for side = 1.
Vector3d OnSide(int side, const Vector3d& left) {
  return side == 0 ? left : Vector3d(-left.x(), left.y(), left.z());
}

void AddTrunk(std::array<BoneShape, kNumBones>& bones) {
  bones[kPelvis] = {
      -1, {0, 0, .96}, {0, 0, .90}, {0, 0, 1.00}, {Ellipsoid({0, .012, .94}, {.160, .110, .125})}};
  bones[kBelly] = {kPelvis,
                   {0, 0, 1.04},
                   {0, 0, 1.00},
                   {0, 0, 1.18},
                   {Ellipsoid({0, 0, 1.09}, {.098, .074, .17})}};
  bones[kChest] = {kBelly,
                   {0, .01, 1.18},
                   {0, 0, 1.18},
                   {0, 0, 1.37},
                   {Ellipsoid({0, .005, 1.27}, {.142, .098, .165}),
                    Cone({-.145, .008, 1.378}, {.145, .008, 1.378}, .048, .048)}};
  bones[kNeck] = {kChest,
                  {0, .012, 1.42},
                  {0, .012, 1.42},
                  {0, 0, 1.50},
                  {Cone({0, .012, 1.40}, {0, 0, 1.52}, .052, .048)}};
  bones[kHead] = {kNeck,
                  {0, 0, 1.52},
                  {0, -.012, 1.55},
                  {0, -.012, 1.66},
                  {Ellipsoid({0, -.012, 1.605}, {.076, .093, .115})}};
}

void AddArm(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d down(std::sin(kRestArmAngle), 0, -std::cos(kRestArmAngle));
  const Vector3d shoulder(.168, .008, 1.380);
  const Vector3d elbow = shoulder + .28 * down, wrist = elbow + .25 * down,
                 fingers = wrist + .14 * down;
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kUpperArm + side] = {
      kChest, at(shoulder), at(shoulder), at(elbow), {Cone(at(shoulder), at(elbow), .050, .034)}};
  bones[kForearm + side] = {kUpperArm + side,
                            at(elbow),
                            at(elbow),
                            at(wrist),
                            {Cone(at(elbow), at(wrist), .034, .026),
                             Cone(at(elbow + .04 * down), at(elbow + .10 * down), .033, .030)}};
  bones[kHand + side] = {kForearm + side,
                         at(wrist),
                         at(wrist),
                         at(fingers),
                         {Cone(at(wrist + .05 * down), at(fingers), .036, .028)}};
}

void AddLeg(int side, std::array<BoneShape, kNumBones>& bones) {
  const Vector3d hip(.090, 0, .91), knee(.135, -.01, .50), ankle(.165, .02, .085);
  const Vector3d heel(.165, .035, .040), toes(.185, -.150, .034);
  const auto at = [&](const Vector3d& left) { return OnSide(side, left); };
  bones[kThigh + side] = {
      kPelvis, at(hip), at(hip), at(knee), {Cone(at(hip), at(knee), .083, .048)}};
  bones[kShin + side] = {kThigh + side,
                         at(knee),
                         at(knee),
                         at(ankle),
                         {Cone(at(knee), at(ankle), .046, .034),
                          Cone(at({.139, .010, .43}), at({.150, .022, .28}), .042, .036)}};
  bones[kFoot + side] = {
      kShin + side, at(ankle), at(heel), at(toes), {Cone(at(heel), at(toes), .040, .034)}};
}

// The cone with round ends, exact where the ends do not contain one another [m].
double ConeDistance(const Flesh& cone, const Vector3d& point) {
  const Vector3d axis = cone.b - cone.a, p = point - cone.a;
  const double length = axis.norm(), along = p.dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, p.squaredNorm() - along * along));
  const double slope = (cone.radius_a - cone.radius_b) / length;
  const double rise = std::sqrt(1 - slope * slope);
  const double foot = along - across * slope / rise;  // of the normal of the cone, on the axis
  if (foot < 0) return p.norm() - cone.radius_a;
  if (foot > length) return (point - cone.b).norm() - cone.radius_b;
  return across * rise + along * slope - cone.radius_a;
}

double EllipsoidDistance(const Flesh& ellipsoid, const Vector3d& point) {
  const Vector3d scaled = (point - ellipsoid.a).cwiseQuotient(ellipsoid.half_axes);
  const double value = scaled.norm();
  const double slope = scaled.cwiseQuotient(ellipsoid.half_axes).norm();
  if (slope < 1e-9) return -ellipsoid.half_axes.minCoeff();
  return value * (value - 1) / slope;
}

AngleAxisd About(const Vector3d& axis, double angle) { return {angle, axis}; }

// The rotation of each bone in its parent.
std::array<Eigen::Quaterniond, kNumBones> JointRotations(const Pose& pose) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  std::array<Eigen::Quaterniond, kNumBones> turn;
  turn.fill(Eigen::Quaterniond::Identity());
  turn[kPelvis] = (About(z, pose.yaw) * About(y, pose.roll));
  turn[kBelly] = About(z, pose.belly_twist);
  turn[kChest] = (About(z, pose.chest_twist) * About(x, pose.chest_bend));
  turn[kHead] = About(z, pose.head_turn);
  for (int side = 0; side < 2; ++side) {
    const double away = side == 0 ? -1 : 1;  // about y, from the body
    turn[kThigh + side] = About(x, -pose.hip[side]);
    turn[kShin + side] = About(x, pose.knee[side]);
    turn[kFoot + side] = About(x, -pose.ankle[side]);
    turn[kUpperArm + side] = (About(x, -pose.arm[side]) * About(y, away * pose.arm_lift[side]));
    turn[kForearm + side] = About(x, -pose.elbow[side]);
  }
  return turn;
}

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

const std::array<BoneShape, kNumBones>& Skeleton() {
  static const std::array<BoneShape, kNumBones> bones = [] {
    std::array<BoneShape, kNumBones> made;
    AddTrunk(made);
    for (int side = 0; side < 2; ++side) {
      AddArm(side, made);
      AddLeg(side, made);
    }
    return made;
  }();
  return bones;
}

std::array<Eigen::Isometry3d, kNumBones> BoneMotions(const Pose& pose) {
  const auto& bones = Skeleton();
  const auto turn = JointRotations(pose);
  std::array<Eigen::Isometry3d, kNumBones> motion;
  for (int b = 0; b < kNumBones; ++b) {  // parents come first
    const int parent = bones[b].parent;
    motion[b] = parent < 0 ? Eigen::Isometry3d(Eigen::Translation3d(pose.shift)) : motion[parent];
    motion[b] = motion[b] * Eigen::Translation3d(bones[b].joint) * turn[b] *
                Eigen::Translation3d(-bones[b].joint);
  }
  return motion;
}

double FleshDistance(const Flesh& flesh, const Vector3d& point) {
  return flesh.half_axes.isZero() ? ConeDistance(flesh, point) : EllipsoidDistance(flesh, point);
}

Vector3d NearestOnAxis(const BoneShape& bone, const Vector3d& point) {
  const Vector3d axis = bone.end - bone.begin;
  const double share = (point - bone.begin).dot(axis) / axis.squaredNorm();
  return bone.begin + std::clamp(share, 0.0, 1.0) * axis;
}

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
