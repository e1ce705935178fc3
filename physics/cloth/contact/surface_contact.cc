// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_contact.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/cloth/contact/barrier.h"

namespace drape {
namespace {

std::vector<std::array<int, 2>> ListEnds(const std::vector<RestEdge>& edges) {
  std::vector<std::array<int, 2>> ends;
  for (const RestEdge& edge : edges) ends.push_back({edge.vertex[0], edge.vertex[1]});
  return ends;
}

// Vertices that move by the same share of what was meant for them, so that cloth in contact is not
// pushed into itself by shorter moves of a part of it.
class Islands {
 public:
  explicit Islands(Eigen::Index vertices) : parent_(vertices), share_(vertices, 1.0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  double Share(int i) const { return share_[Root(i)]; }
  void Join(const std::array<int, 4>& vertices) {
    const int first = Root(vertices[0]);
    for (const int i : vertices) {
      const int root = Root(i);
      share_[first] = std::min(share_[first], share_[root]);
      parent_[root] = first;
    }
  }
  void Lower(int i, double share) { share_[Root(i)] = std::min(share_[Root(i)], share); }

 private:
  int Root(int i) const {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  mutable std::vector<int> parent_;
  std::vector<double> share_;
};

PairMatrix PositivePart(const PairMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<PairMatrix> solver(symmetric);
  const PairMatrix& vectors = solver.eigenvectors();
  return vectors * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}
PairMatrix SelectPart(const PairMatrix& symmetric, SurfaceContact::StiffnessPart part) {
  switch (part) {
    case SurfaceContact::StiffnessPart::kPositive:
      return PositivePart(symmetric);
    case SurfaceContact::StiffnessPart::kNegative:
      return -PositivePart(-symmetric);
    case SurfaceContact::StiffnessPart::kWhole:
      break;
  }
  return symmetric;
}

}  // namespace

SurfaceContact::SurfaceContact(const Mesh& mesh, Eigen::VectorXd vertex_area,
                               const Contact& surface)
    : surface_(surface),
      rest_x_(mesh.rest_x),
      vertex_area_(std::move(vertex_area)),
      edges_(ListEdges(mesh)),
      candidates_(ListEnds(edges_), ListTriangles(mesh), surface.thickness + surface.range) {
  CHECK_EQ(vertex_area_.size(), mesh.num_vertices());
}

void SurfaceContact::Know(const Eigen::VectorXd& x) {
  if (!candidates_.Covers(x)) candidates_.Cover(x, Eigen::VectorXd::Zero(x.size()));
}

bool SurfaceContact::ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  constexpr int kMostRounds = 30;
  constexpr double kWithin = 0.98;  // of a share, so that the next round finds the moves safe
  candidates_.Cover(x, dx);
  const auto near = candidates_.Near(x, LongestMove(dx));
  const Eigen::VectorXd meant = dx;
  const Eigen::Index vertices = x.size() / 3;
  Islands islands(vertices);
  for (const SurfaceTouch& touch : ListTouches(x)) islands.Join(touch.pair.vertex);
  std::vector<bool> changed(vertices, true);
  std::vector<double> now(vertices, 1.0);  // the shares in dx
  for (int round = 0; round < kMostRounds; ++round) {
    bool safe = true;
    for (const auto& [distance, pair] : near) {
      const auto has_changed = [&](int i) { return changed[i]; };
      if (std::none_of(pair.vertex.begin(), pair.vertex.end(), has_changed)) continue;
      const double share =
          SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx), surface_.thickness);
      if (share == 1.0) continue;
      safe = false;
      for (const int i : pair.vertex) islands.Lower(i, kWithin * share * now[i]);
      islands.Join(pair.vertex);
    }
    if (safe) return round > 0;
    for (int i = 0; i < vertices; ++i) {
      changed[i] = islands.Share(i) != now[i];
      now[i] = islands.Share(i);
      dx.segment<3>(3 * i) = now[i] * meant.segment<3>(3 * i);
    }
  }
  double safe = 1.0;
  for (const auto& [distance, pair] : near)
    safe = std::min(safe, SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx),
                                    surface_.thickness));
  dx *= safe;
  return true;
}

const RestEdge& SurfaceContact::EdgeBetween(int a, int b) const {
  const auto before = [](const RestEdge& edge, const std::array<int, 2>& ends) {
    return std::pair(edge.vertex[0], edge.vertex[1]) < std::pair(ends[0], ends[1]);
  };
  return *std::lower_bound(edges_.begin(), edges_.end(), std::array{std::min(a, b), std::max(a, b)},
                           before);
}

double SurfaceContact::Area(const ContactPair& pair) const {
  const auto& [a, b, c, d] = pair.vertex;
  // A half of the pressure is of vertices and faces, of either side a quarter, and a half of edges.
  return pair.of_edges ? 0.125 * (EdgeBetween(a, b).area + EdgeBetween(c, d).area)
                       : 0.25 * vertex_area_[a];
}

double SurfaceContact::RestSquares(const ContactPair& pair) const {
  const auto& [a, b, c, d] = pair.vertex;
  return std::pow(EdgeBetween(a, b).rest_length * EdgeBetween(c, d).rest_length, 2);
}

bool SurfaceContact::Pushes(const ContactPair& pair) const {
  return MeasureDistance(pair.of_edges, GatherPair(pair, rest_x_)).value >= Reach();
}

std::vector<SurfaceTouch> SurfaceContact::ListTouches(const Eigen::VectorXd& x) const {
  std::vector<SurfaceTouch> touches;
  for (const auto& [reference_distance, pair] : candidates_.Near(x, 0.0)) {
    const PairColumns columns = GatherPair(pair, x);
    const PairDistance distance = MeasureDistance(pair.of_edges, columns);
    if (distance.value >= Reach() || !Pushes(pair)) continue;
    SurfaceTouch touch{.pair = pair, .distance = distance, .area = Area(pair), .mollifier = {}};
    if (pair.of_edges) touch.mollifier = MollifyParallel(columns, RestSquares(pair));
    touches.push_back(touch);
  }
  // The order of candidates depends on the way to x, sums must not.
  std::sort(touches.begin(), touches.end(),
            [](const SurfaceTouch& a, const SurfaceTouch& b) { return a.pair < b.pair; });
  return touches;
}

double SurfaceContact::NormalForce(const SurfaceTouch& touch) const {
  return -surface_.stiffness * touch.area * touch.mollifier.value *
         EvaluateBarrier(Gap(touch), surface_.range).slope;
}

double SurfaceContact::AddForces(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
  double energy = 0.0;
  for (const SurfaceTouch& touch : ListTouches(x)) {
    const double scale = surface_.stiffness * touch.area;
    const double barrier = EvaluateBarrier(Gap(touch), surface_.range).value;
    const Eigen::Vector3d push = NormalForce(touch) * touch.distance.normal;
    for (int i = 0; i < 4; ++i)
      f.segment<3>(3 * touch.pair.vertex[i]) +=
          touch.distance.weight[i] * push - scale * barrier * touch.mollifier.gradient.col(i);
    energy += scale * touch.mollifier.value * barrier;
  }
  return energy;
}

void SurfaceContact::ForEachStiffness(const Eigen::VectorXd& x, StiffnessPart part,
                                      const BlockVisitor& add) const {
  for (const SurfaceTouch& touch : ListTouches(x)) {
    const PairMatrix stiffness = SelectPart(Curvature(touch, x), part);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int row = touch.pair.vertex[i], column = touch.pair.vertex[j];
        if (row <= column) add(row, column, stiffness.block<3, 3>(3 * i, 3 * j));
      }
  }
}

// Of the energy of one pair [N/m].
PairMatrix SurfaceContact::Curvature(const SurfaceTouch& touch, const Eigen::VectorXd& x) const {
  const PairColumns columns = GatherPair(touch.pair, x);
  const Barrier barrier = EvaluateBarrier(Gap(touch), surface_.range);
  const Eigen::Vector<double, 12> by_distance =
      (touch.distance.normal * touch.distance.weight.transpose()).reshaped();
  PairMatrix curvature =
      touch.mollifier.value *
      (barrier.curvature * by_distance * by_distance.transpose() +
       barrier.slope * DistanceCurvature(touch.pair.of_edges, columns, touch.distance));
  if (touch.mollifier.value < 1.0) {
    const Eigen::Vector<double, 12> by_angle = touch.mollifier.gradient.reshaped();
    const PairMatrix mixed = by_distance * by_angle.transpose();
    curvature += barrier.slope * (mixed + mixed.transpose()) +
                 barrier.value * MollifierCurvature(columns, RestSquares(touch.pair));
  }
  return surface_.stiffness * touch.area * curvature;
}

std::vector<std::array<int, 4>> SurfaceContact::ListNear(const Eigen::VectorXd& x) const {
  constexpr double kSoon = 2.0;  // by the reach
  std::vector<std::array<int, 4>> near;
  for (const auto& [reference_distance, pair] : candidates_.Near(x, 0.5 * (kSoon - 1.0) * Reach()))
    if (MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kSoon * Reach() && Pushes(pair))
      near.push_back(pair.vertex);
  return near;
}

double SurfaceContact::SmallestGap(const Eigen::VectorXd& x) const {
  double smallest = surface_.range;
  for (const SurfaceTouch& touch : ListTouches(x)) smallest = std::min(smallest, Gap(touch));
  return smallest;
}

}  // namespace drape
