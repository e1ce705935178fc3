// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_contact.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <variant>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/vertex_contact.h"

namespace drape {
namespace {

SurfaceParts PartsOfCloth(const Mesh& mesh, const std::vector<RestEdge>& edges) {
  SurfaceParts parts{.vertices = std::vector<int>(mesh.num_vertices()),
                     .triangles = ListTriangles(mesh)};
  std::iota(parts.vertices.begin(), parts.vertices.end(), 0);
  for (const RestEdge& edge : edges) parts.edges.push_back({edge.vertex[0], edge.vertex[1]});
  return parts;
}

// Of a closed surface, whose vertices are numbered from `first` on.
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

Eigen::VectorXd Joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd joined(a.size() + b.size());
  joined << a, b;
  return joined;
}

// Vertices that move by the same share of what was meant for them, so that cloth in contact is not
// pushed into itself by shorter moves of a part of it.
class Islands {
 public:
  explicit Islands(Eigen::Index vertices) : parent_(vertices), share_(vertices, 1.0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  double Share(int i) const { return share_[Root(i)]; }
  // Of the vertices of a pair, those of the cloth.
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
                               const std::optional<Contact>& self)
    : self_layer_(self ? Layer{self->thickness, self->range, self->stiffness} : Layer{}),
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
  touched_x_.resize(0);
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
      PartsOfObstacles(static_cast<int>(CoordinatesOfCloth() / 3),
                       static_cast<int>(obstacle_x_.size() / 3), obstacle_triangles_),
      std::max(self_layer_.reach(), obstacle_layer_.reach()));
}

bool SurfaceContact::IsOfObstacle(const ContactPair& pair) const {
  return !IsOfCloth(pair.vertex[0]) || !IsOfCloth(pair.vertex[3]);
}

int SurfaceContact::FirstOfCloth(const ContactPair& pair) const {
  return *std::find_if(pair.vertex.begin(), pair.vertex.end(), [&](int i) { return IsOfCloth(i); });
}

Eigen::VectorXd SurfaceContact::WithObstacles(const Eigen::VectorXd& x) const {
  return Joined(x, obstacle_x_);
}
Eigen::VectorXd SurfaceContact::WithResting(const Eigen::VectorXd& dx) const {
  return Joined(dx, Eigen::VectorXd::Zero(obstacle_x_.size()));
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

// x and dx are of cloth and obstacles.
bool SurfaceContact::IsSafe(const ContactPair& pair, const Eigen::VectorXd& x,
                            const Eigen::VectorXd& dx) const {
  return SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx),
                   LayerBetween(pair).thickness) == 1.0;
}

bool SurfaceContact::CanFollow(const Eigen::VectorXd& x, const Eigen::VectorXd& dx) {
  const Eigen::VectorXd from = Joined(x, obstacle_before_),
                        moves = Joined(dx, obstacle_x_ - obstacle_before_);
  candidates_.Cover(from, moves);
  const auto near = candidates_.Near(from, LongestMove(moves));
  return std::all_of(near.begin(), near.end(), [&](const PairCandidates::Candidate& candidate) {
    return IsSafe(candidate.pair, from, moves);
  });
}

// Lets the vertices of the cloth in a pair yield, by least squares, to what is left of the closing
// of its parts when they come too near. x and dx are of cloth and obstacles.
void SurfaceContact::PushApart(const ContactPair& pair, const Eigen::VectorXd& x,
                               Eigen::VectorXd& dx) const {
  constexpr double kMore = 1.2;
  const PairColumns places = GatherPair(pair, x), moves = GatherPair(pair, dx);
  const double share = SafeShare(pair.of_edges, places, moves, LayerBetween(pair).thickness);
  const PairDistance distance = MeasureDistance(pair.of_edges, places + share * moves);
  const double closing = -distance.normal.dot(moves * distance.weight);
  double squares = 0.0;
  for (int i = 0; i < 4; ++i)
    if (IsOfCloth(pair.vertex[i])) squares += std::pow(distance.weight[i], 2);
  if (!(closing > 0.0) || squares == 0.0) return;
  const Eigen::Vector3d push = kMore * (1.0 - share) * closing / squares * distance.normal;
  for (int i = 0; i < 4; ++i)
    if (IsOfCloth(pair.vertex[i])) dx.segment<3>(3 * pair.vertex[i]) += distance.weight[i] * push;
}

std::optional<int> SurfaceContact::GiveWay(const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  constexpr int kMostParts = 32, kMostRounds = 30;
  int in_the_way = 0;
  for (int parts = 1; parts <= kMostParts; parts *= 2) {
    const Eigen::VectorXd part = Joined(dx, obstacle_x_ - obstacle_before_) / parts;
    Eigen::VectorXd from = Joined(x, obstacle_before_);
    bool is_free = true;
    for (int k = 0; k < parts && is_free; ++k) {
      Eigen::VectorXd moves = part;
      is_free = false;
      for (int round = 0; round < kMostRounds && !is_free; ++round) {
        candidates_.Cover(from, moves);
        is_free = true;
        for (const auto& [distance, pair] : candidates_.Near(from, LongestMove(moves))) {
          if (IsSafe(pair, from, moves)) continue;
          is_free = false;
          in_the_way = FirstOfCloth(pair);
          PushApart(pair, from, moves);
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

void SurfaceContact::Know(const Eigen::VectorXd& x) {
  const Eigen::VectorXd all = WithObstacles(x);
  if (!candidates_.Covers(all)) candidates_.Cover(all, Eigen::VectorXd::Zero(all.size()));
}

bool SurfaceContact::ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  constexpr int kMostRounds = 30;
  constexpr double kWithin = 0.98;  // of a share, so that the next round finds the moves safe
  const Eigen::VectorXd from = WithObstacles(x);
  candidates_.Cover(from, WithResting(dx));
  const auto near = candidates_.Near(from, LongestMove(dx));
  const Eigen::VectorXd meant = dx;
  Eigen::VectorXd moves = WithResting(dx);
  const Eigen::Index vertices = x.size() / 3;
  Islands islands(vertices);
  for (const SurfaceTouch& touch : ListTouches(x))
    if (!IsOfObstacle(touch.pair)) islands.Join(touch.pair.vertex);
  std::vector<bool> changed(vertices, true);
  std::vector<double> now(vertices, 1.0);  // the shares in dx
  std::vector<double> shares(near.size());
  const auto has_changed = [&](int i) { return IsOfCloth(i) && changed[i]; };
  for (int round = 0; round < kMostRounds; ++round) {
    bool safe = true;
#pragma omp parallel for num_threads(threads_) if (threads_ > 1)
    for (std::size_t k = 0; k < near.size(); ++k) {
      const ContactPair& pair = near[k].pair;
      const bool looks = std::any_of(pair.vertex.begin(), pair.vertex.end(), has_changed);
      shares[k] = looks ? SafeShare(pair.of_edges, GatherPair(pair, from), GatherPair(pair, moves),
                                    LayerBetween(pair).thickness)
                        : 1.0;
    }
    for (std::size_t k = 0; k < near.size(); ++k) {
      const ContactPair& pair = near[k].pair;
      const double share = shares[k];
      if (share == 1.0) continue;
      safe = false;
      for (const int i : pair.vertex)
        if (IsOfCloth(i)) islands.Lower(i, kWithin * share * now[i]);
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
    safe = std::min(safe, SafeShare(pair.of_edges, GatherPair(pair, from), GatherPair(pair, moves),
                                    LayerBetween(pair).thickness));
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

const std::vector<SurfaceTouch>& SurfaceContact::ListTouches(const Eigen::VectorXd& x) const {
  if (touched_x_.size() == x.size() && touched_x_ == x) return touches_;
  const auto near = candidates_.Near(WithObstacles(x), 0.0);
  std::vector<PairDistance> distances(near.size());
#pragma omp parallel for num_threads(threads_) if (threads_ > 1)
  for (std::size_t k = 0; k < near.size(); ++k)
    distances[k] = MeasureDistance(near[k].pair.of_edges, Gather(near[k].pair, x));
  touches_.clear();
  for (std::size_t k = 0; k < near.size(); ++k) {
    const ContactPair& pair = near[k].pair;
    if (distances[k].value >= LayerBetween(pair).reach() || !Pushes(pair)) continue;
    SurfaceTouch touch{.pair = pair, .distance = distances[k], .area = Area(pair), .mollifier = {}};
    if (pair.of_edges) touch.mollifier = MollifyParallel(Gather(pair, x), RestSquares(pair));
    touches_.push_back(touch);
  }
  // The order of candidates depends on the way to x, sums must not.
  std::sort(touches_.begin(), touches_.end(),
            [](const SurfaceTouch& a, const SurfaceTouch& b) { return a.pair < b.pair; });
  touched_x_ = x;
  return touches_;
}

double SurfaceContact::NormalForce(const SurfaceTouch& touch) const {
  const Layer& layer = LayerBetween(touch.pair);
  return -layer.stiffness * touch.area * touch.mollifier.value *
         EvaluateBarrier(Gap(touch), layer.range).slope;
}

Rub SurfaceContact::RubAt(const SurfaceTouch& touch, const Eigen::VectorXd& before) const {
  Rub rub{.weight = touch.distance.weight, .normal = touch.distance.normal};
  const auto& vertex = touch.pair.vertex;
  Eigen::Vector3d led = Eigen::Vector3d::Zero();  // by an obstacle
  for (int i = 0; i < 4; ++i) {
    rub.vertex[i] = vertex[i];
    if (IsOfCloth(vertex[i])) continue;
    const Eigen::Index at = 3 * vertex[i] - CoordinatesOfCloth();
    led += rub.weight[i] * (obstacle_x_.segment<3>(at) - obstacle_before_.segment<3>(at));
    rub.vertex[i] = FirstOfCloth(touch.pair);
    rub.weight[i] = 0.0;
  }
  rub.start = rub.Point(before) - led;
  return rub;
}

double SurfaceContact::AddForces(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
  double energy = 0.0;
  for (const SurfaceTouch& touch : ListTouches(x)) {
    const Layer& layer = LayerBetween(touch.pair);
    const double scale = layer.stiffness * touch.area;
    const double barrier = EvaluateBarrier(Gap(touch), layer.range).value;
    const Eigen::Vector3d push = NormalForce(touch) * touch.distance.normal;
    for (int i = 0; i < 4; ++i)
      if (IsOfCloth(touch.pair.vertex[i]))
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
        if (row <= column && IsOfCloth(column))
          add(row, column, stiffness.block<3, 3>(3 * i, 3 * j));
      }
  }
}

// Of the energy of one pair [N/m].
PairMatrix SurfaceContact::Curvature(const SurfaceTouch& touch, const Eigen::VectorXd& x) const {
  const Layer& layer = LayerBetween(touch.pair);
  const PairColumns columns = Gather(touch.pair, x);
  const Barrier barrier = EvaluateBarrier(Gap(touch), layer.range);
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
  return layer.stiffness * touch.area * curvature;
}

std::vector<std::array<int, 4>> SurfaceContact::ListNear(const Eigen::VectorXd& x) const {
  constexpr double kSoon = 4.0;  // by the reach
  const double reach = self_layer_.reach();
  std::vector<std::array<int, 4>> near;
  for (const auto& [reference_distance, pair] :
       candidates_.Near(WithObstacles(x), 0.5 * (kSoon - 1.0) * reach))
    if (!IsOfObstacle(pair) &&
        MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kSoon * reach && Pushes(pair))
      near.push_back(pair.vertex);
  return near;
}

double SurfaceContact::SmallestGap(const Eigen::VectorXd& x) const {
  double smallest = std::max(self_layer_.range, obstacle_layer_.range);
  for (const SurfaceTouch& touch : ListTouches(x)) smallest = std::min(smallest, Gap(touch));
  return smallest;
}

}  // namespace drape
