// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_contact.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <variant>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"

namespace drape {
namespace {

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

}  // namespace

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

}  // namespace drape
