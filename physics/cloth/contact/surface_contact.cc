// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_contact.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <variant>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/vertex_contact.h"

namespace drape {
namespace {

PairMatrix PositivePart(const PairMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<PairMatrix> solver(symmetric);
  const PairMatrix& vectors = solver.eigenvectors();
  return vectors * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}
PairMatrix SelectPart(const PairMatrix& symmetric, StiffnessPart part) {
  return part == StiffnessPart::kPositive ? PositivePart(symmetric) : symmetric;
}

// The second derivative of the energy of one pair [N/m].
PairMatrix Curvature(const ActivePair& pair) {
  const Barrier barrier = EvaluateBarrier(pair.gap(), pair.layer.range);
  const Eigen::Vector<double, 12> by_distance =
      (pair.distance.normal * pair.distance.weight.transpose()).reshaped();
  PairMatrix curvature =
      pair.mollifier.value *
      (barrier.curvature * by_distance * by_distance.transpose() +
       barrier.slope * DistanceCurvature(pair.pair.of_edges, pair.places, pair.distance));
  if (pair.mollifier.value < 1.0) {
    const Eigen::Vector<double, 12> by_angle = pair.mollifier.gradient.reshaped();
    const PairMatrix mixed = by_distance * by_angle.transpose();
    curvature += barrier.slope * (mixed + mixed.transpose()) +
                 barrier.value * MollifierCurvature(pair.places, pair.rest_squares);
  }
  return pair.layer.stiffness * pair.area * curvature;
}

SurfaceParts PartsOfCloth(const Mesh& mesh, const std::vector<RestEdge>& edges) {
  SurfaceParts parts{.vertices = std::vector<int>(mesh.num_vertices()),
                     .triangles = ListTriangles(mesh)};
  std::iota(parts.vertices.begin(), parts.vertices.end(), 0);
  for (const RestEdge& edge : edges) parts.edges.push_back({edge.vertex[0], edge.vertex[1]});
  return parts;
}

// The parts of a closed surface. Its vertices are numbered from `first` on.
SurfaceParts PartsOfObstacles(int first, int vertices,
                              const std::vector<std::array<int, 3>>& triangles) {
  SurfaceParts parts{.vertices = std::vector<int>(vertices)};
  std::iota(parts.vertices.begin(), parts.vertices.end(), first);
  for (const auto& [p, q, r] : triangles) {
    parts.triangles.push_back({first + p, first + q, first + r});
    for (const auto& [a, b] : {std::array{p, q}, {q, r}, {r, p}})
      if (a < b) parts.edges.push_back({first + a, first + b});
  }
  return parts;
}

// Vertices that move by the same share of what was meant for them, so that cloth in contact is not
// pushed into itself by shorter moves of a part of it.
class Islands {
 public:
  explicit Islands(Eigen::Index vertices) : parent_(vertices), share_(vertices, 1.0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  double Share(int i) const { return share_[Root(i)]; }
  // Joins the vertices of a pair that belong to the cloth.
  void Join(const std::array<int, 4>& vertices) {
    const auto is_cloth = [&](int i) { return i < static_cast<int>(parent_.size()); };
    const int first = Root(*std::find_if(vertices.begin(), vertices.end(), is_cloth));
    for (const int i : vertices) {
      if (!is_cloth(i)) continue;
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

// Returns the share of the step dx that is free for a pair; x and dx are of cloth and obstacles.
double FreeShare(const SurfaceContact& surfaces, const ContactPair& pair, const Eigen::VectorXd& x,
                 const Eigen::VectorXd& dx) {
  return SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx),
                   surfaces.LayerBetween(pair).thickness);
}

int FirstOfCloth(const SurfaceContact& surfaces, const ContactPair& pair) {
  return *std::find_if(pair.vertex.begin(), pair.vertex.end(),
                       [&](int i) { return surfaces.IsOfCloth(i); });
}

// Lets the vertices of the cloth in a pair yield, by least squares, to what is left of the closing
// of its parts when they come too near. x and dx are of cloth and obstacles.
void PushApart(const SurfaceContact& surfaces, const ContactPair& pair, const Eigen::VectorXd& x,
               Eigen::VectorXd& dx) {
  constexpr double kMore = 1.2;
  const PairColumns places = GatherPair(pair, x), moves = GatherPair(pair, dx);
  const double share =
      SafeShare(pair.of_edges, places, moves, surfaces.LayerBetween(pair).thickness);
  const PairDistance distance = MeasureDistance(pair.of_edges, places + share * moves);
  const double closing = -distance.normal.dot(moves * distance.weight);
  double squares = 0.0;
  for (int i = 0; i < 4; ++i)
    if (surfaces.IsOfCloth(pair.vertex[i])) squares += std::pow(distance.weight[i], 2);
  if (!(closing > 0.0) || squares == 0.0) return;
  const Eigen::Vector3d push = kMore * (1.0 - share) * closing / squares * distance.normal;
  for (int i = 0; i < 4; ++i)
    if (surfaces.IsOfCloth(pair.vertex[i]))
      dx.segment<3>(3 * pair.vertex[i]) += distance.weight[i] * push;
}

}  // namespace

double AddPairForces(const ActivePairs& pairs, Eigen::VectorXd& f) {
  double energy = 0.0;
  for (const ActivePair& pair : pairs) {
    const double scale = pair.layer.stiffness * pair.area;
    const double barrier = EvaluateBarrier(pair.gap(), pair.layer.range).value;
    const Eigen::Vector3d push = NormalForce(pair) * pair.distance.normal;
    for (int i = 0; i < 4; ++i)
      if (pair.of_cloth[i])
        f.segment<3>(3 * pair.pair.vertex[i]) +=
            pair.distance.weight[i] * push - scale * barrier * pair.mollifier.gradient.col(i);
    energy += scale * pair.mollifier.value * barrier;
  }
  return energy;
}

void ForEachPairStiffness(const ActivePairs& pairs, StiffnessPart part, const BlockVisitor& add) {
  for (const ActivePair& pair : pairs) {
    const PairMatrix stiffness = SelectPart(Curvature(pair), part);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int row = pair.pair.vertex[i], column = pair.pair.vertex[j];
        if (row <= column && pair.of_cloth[j])
          add(row, column, stiffness.block<3, 3>(3 * i, 3 * j));
      }
  }
}

double NormalForce(const ActivePair& pair) {
  return -pair.layer.stiffness * pair.area * pair.mollifier.value *
         EvaluateBarrier(pair.gap(), pair.layer.range).slope;
}

Rub MakeRub(const ActivePair& pair, const Eigen::VectorXd& before) {
  Rub rub{.weight = pair.distance.weight, .normal = pair.distance.normal};
  const auto first = std::find(pair.of_cloth.begin(), pair.of_cloth.end(), true);
  const int of_cloth = pair.pair.vertex[first - pair.of_cloth.begin()];
  for (int i = 0; i < 4; ++i) {
    rub.vertex[i] = pair.of_cloth[i] ? pair.pair.vertex[i] : of_cloth;
    if (!pair.of_cloth[i]) rub.weight[i] = 0.0;
  }
  rub.start = rub.Point(before) - pair.obstacle_move;
  return rub;
}

SurfaceContact::SurfaceContact(const Mesh& mesh, Eigen::VectorXd vertex_area,
                               const std::optional<Contact>& self)
    : self_layer_(self ? ContactLayer{self->thickness, self->range, self->stiffness}
                       : ContactLayer{}),
      rest_x_(mesh.rest_x),
      vertex_area_(std::move(vertex_area)),
      edges_(ListEdges(mesh)),
      candidates_(PartsOfCloth(mesh, edges_), self_layer_.reach(), self.has_value()) {
  CHECK_EQ(vertex_area_.size(), mesh.num_vertices());
}

void SurfaceContact::SetObstacles(const Contact& around) {
  obstacle_layer_ = {0.5 * around.thickness, around.range, around.stiffness};
  obstacle_x_.resize(0);
  obstacle_before_.resize(0);
  active_x_.resize(0);
  std::vector<std::array<int, 3>> triangles;
  for (const Obstacle& obstacle : around.obstacles) {
    const auto* surface = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle);
    if (surface == nullptr) continue;
    const auto first = static_cast<int>(obstacle_x_.size() / 3);
    for (const auto& [p, q, r] : (*surface)->triangles())
      triangles.push_back({first + p, first + q, first + r});
    obstacle_x_ = Joined(obstacle_x_, (*surface)->x().reshaped());
    obstacle_before_ = Joined(obstacle_before_, (*surface)->before().reshaped());
  }
  if (triangles == obstacle_triangles_) return;
  obstacle_triangles_ = std::move(triangles);
  candidates_.SetObstacles(
      PartsOfObstacles(static_cast<int>(rest_x_.size() / 3),
                       static_cast<int>(obstacle_x_.size() / 3), obstacle_triangles_),
      std::max(self_layer_.reach(), obstacle_layer_.reach()));
}

bool SurfaceContact::IsOfObstacle(const ContactPair& pair) const {
  return !IsOfCloth(pair.vertex[0]) || !IsOfCloth(pair.vertex[3]);
}

Eigen::VectorXd SurfaceContact::WithObstacles(const Eigen::VectorXd& x) const {
  return Joined(x, obstacle_x_);
}

PairColumns SurfaceContact::Gather(const ContactPair& pair, const Eigen::VectorXd& x) const {
  PairColumns columns;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Index at = 3 * pair.vertex[i];
    columns.col(i) =
        IsOfCloth(pair.vertex[i]) ? x.segment<3>(at) : obstacle_x_.segment<3>(at - x.size());
  }
  return columns;
}

std::span<const PairCandidates::Candidate> SurfaceContact::FindCandidates(
    const Eigen::VectorXd& x, const Eigen::VectorXd& dx) {
  candidates_.Cover(x, dx);
  return candidates_.Near(x, LongestMove(dx));
}

void SurfaceContact::Cover(const Eigen::VectorXd& x) {
  const Eigen::VectorXd all = WithObstacles(x);
  if (!candidates_.Covers(all)) candidates_.Cover(all, Eigen::VectorXd::Zero(all.size()));
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
  if (IsOfObstacle(pair))
    return pair.of_edges ? 0.25 * EdgeBetween(a, b).area
                         : 0.25 * (vertex_area_[b] + vertex_area_[c] + vertex_area_[d]) / 3.0;
  return pair.of_edges ? 0.125 * (EdgeBetween(a, b).area + EdgeBetween(c, d).area)
                       : 0.25 * vertex_area_[a];
}

double SurfaceContact::RestSquares(const ContactPair& pair) const {
  const auto& [a, b, c, d] = pair.vertex;
  if (IsOfObstacle(pair)) {
    const PairColumns places = Gather(pair, rest_x_);
    return std::pow(EdgeBetween(a, b).rest_length, 2) *
           (places.col(3) - places.col(2)).squaredNorm();
  }
  return std::pow(EdgeBetween(a, b).rest_length * EdgeBetween(c, d).rest_length, 2);
}

bool SurfaceContact::Pushes(const ContactPair& pair) const {
  if (IsOfObstacle(pair)) return !IsOfCloth(pair.vertex[0]) || pair.of_edges;
  return MeasureDistance(pair.of_edges, GatherPair(pair, rest_x_)).value >= self_layer_.reach();
}

ActivePair SurfaceContact::Activate(const ContactPair& pair, const PairDistance& distance,
                                    const Eigen::VectorXd& x) const {
  ActivePair active{.pair = pair,
                    .places = Gather(pair, x),
                    .distance = distance,
                    .area = Area(pair),
                    .mollifier = {},
                    .rest_squares = pair.of_edges ? RestSquares(pair) : 0.0,
                    .layer = LayerBetween(pair),
                    .of_cloth = {},
                    .obstacle_move = Eigen::Vector3d::Zero()};
  if (pair.of_edges) active.mollifier = MollifyParallel(active.places, active.rest_squares);
  for (int i = 0; i < 4; ++i) {
    active.of_cloth[i] = IsOfCloth(pair.vertex[i]);
    if (active.of_cloth[i]) continue;
    const Eigen::Index at = 3 * pair.vertex[i] - rest_x_.size();
    active.obstacle_move +=
        distance.weight[i] * (obstacle_x_.segment<3>(at) - obstacle_before_.segment<3>(at));
  }
  return active;
}

const ActivePairs& SurfaceContact::FindActivePairs(const Eigen::VectorXd& x) {
  if (active_x_.size() == x.size() && active_x_ == x) return active_;
  Cover(x);
  const auto near = candidates_.Near(WithObstacles(x), 0.0);
  std::vector<PairDistance> distances(near.size());
#pragma omp parallel for num_threads(threads_) if (threads_ > 1)
  for (std::size_t k = 0; k < near.size(); ++k)
    distances[k] = MeasureDistance(near[k].pair.of_edges, Gather(near[k].pair, x));
  active_.clear();
  for (std::size_t k = 0; k < near.size(); ++k) {
    const ContactPair& pair = near[k].pair;
    if (distances[k].value < LayerBetween(pair).reach() && Pushes(pair))
      active_.push_back(Activate(pair, distances[k], x));
  }
  // The order of candidates depends on the way to x; sums must not.
  std::sort(active_.begin(), active_.end(),
            [](const ActivePair& a, const ActivePair& b) { return a.pair < b.pair; });
  active_x_ = x;
  return active_;
}

std::vector<std::array<int, 4>> SurfaceContact::ListNear(const Eigen::VectorXd& x) {
  constexpr double kSoon = 4.0;  // by the reach
  const double reach = self_layer_.reach();
  Cover(x);
  std::vector<std::array<int, 4>> near;
  for (const auto& [reference_distance, pair] :
       candidates_.Near(WithObstacles(x), 0.5 * (kSoon - 1.0) * reach))
    if (!IsOfObstacle(pair) &&
        MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kSoon * reach && Pushes(pair))
      near.push_back(pair.vertex);
  return near;
}

double SurfaceContact::SmallestGap(const Eigen::VectorXd& x) {
  double smallest = std::max(self_layer_.range, obstacle_layer_.range);
  for (const ActivePair& pair : FindActivePairs(x)) smallest = std::min(smallest, pair.gap());
  return smallest;
}

bool IsStepFree(SurfaceContact& surfaces, const Eigen::VectorXd& x, const Eigen::VectorXd& dx) {
  const Eigen::VectorXd from = Joined(x, surfaces.obstacle_before());
  const Eigen::VectorXd moves = Joined(dx, surfaces.obstacle_x() - surfaces.obstacle_before());
  const auto near = surfaces.FindCandidates(from, moves);
  return std::all_of(near.begin(), near.end(), [&](const PairCandidates::Candidate& candidate) {
    return FreeShare(surfaces, candidate.pair, from, moves) == 1.0;
  });
}

std::optional<int> FindFreeStep(SurfaceContact& surfaces, const Eigen::VectorXd& x,
                                Eigen::VectorXd& dx) {
  constexpr int kMostParts = 32, kMostRounds = 30;
  int in_the_way = 0;
  for (int parts = 1; parts <= kMostParts; parts *= 2) {
    const Eigen::VectorXd part =
        Joined(dx, surfaces.obstacle_x() - surfaces.obstacle_before()) / parts;
    Eigen::VectorXd from = Joined(x, surfaces.obstacle_before());
    bool is_free = true;
    for (int k = 0; k < parts && is_free; ++k) {
      Eigen::VectorXd moves = part;
      is_free = false;
      for (int round = 0; round < kMostRounds && !is_free; ++round) {
        is_free = true;
        for (const auto& [distance, pair] : surfaces.FindCandidates(from, moves)) {
          if (FreeShare(surfaces, pair, from, moves) == 1.0) continue;
          is_free = false;
          in_the_way = FirstOfCloth(surfaces, pair);
          PushApart(surfaces, pair, from, moves);
        }
      }
      from += moves;
    }
    if (!is_free) continue;
    dx = from.head(x.size()) - x;
    return std::nullopt;
  }
  return in_the_way;
}

bool LimitStep(SurfaceContact& surfaces, const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  constexpr int kMostRounds = 30;
  constexpr double kWithin = 0.98;  // of a share, so that the next round finds the moves safe
  const Eigen::VectorXd from = Joined(x, surfaces.obstacle_x());
  Eigen::VectorXd moves = Joined(dx, Eigen::VectorXd::Zero(surfaces.obstacle_x().size()));
  const auto near = surfaces.FindCandidates(from, moves);
  const Eigen::VectorXd meant = dx;
  const Eigen::Index vertices = x.size() / 3;
  Islands islands(vertices);
  for (const ActivePair& active : surfaces.FindActivePairs(x))
    if (!active.of_obstacle()) islands.Join(active.pair.vertex);
  std::vector<bool> changed(vertices, true);
  std::vector<double> now(vertices, 1.0);  // the shares in dx
  std::vector<double> shares(near.size());
  const auto has_changed = [&](int i) { return surfaces.IsOfCloth(i) && changed[i]; };
  for (int round = 0; round < kMostRounds; ++round) {
    bool safe = true;
#pragma omp parallel for num_threads(surfaces.threads()) if (surfaces.threads() > 1)
    for (std::size_t k = 0; k < near.size(); ++k) {
      const ContactPair& pair = near[k].pair;
      const bool looks = std::any_of(pair.vertex.begin(), pair.vertex.end(), has_changed);
      shares[k] = looks ? FreeShare(surfaces, pair, from, moves) : 1.0;
    }
    for (std::size_t k = 0; k < near.size(); ++k) {
      const ContactPair& pair = near[k].pair;
      const double share = shares[k];
      if (share == 1.0) continue;
      safe = false;
      for (const int i : pair.vertex)
        if (surfaces.IsOfCloth(i)) islands.Lower(i, kWithin * share * now[i]);
      islands.Join(pair.vertex);
    }
    if (safe) return round > 0;
    for (int i = 0; i < vertices; ++i) {
      changed[i] = islands.Share(i) != now[i];
      now[i] = islands.Share(i);
      dx.segment<3>(3 * i) = now[i] * meant.segment<3>(3 * i);
    }
    moves.head(dx.size()) = dx;
  }
  double safe = 1.0;
  for (const auto& [distance, pair] : near)
    safe = std::min(safe, FreeShare(surfaces, pair, from, moves));
  dx *= safe;
  return true;
}

}  // namespace drape
