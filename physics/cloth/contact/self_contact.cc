// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/self_contact.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "physics/cloth/contact/barrier.h"

namespace drape {
namespace {

std::vector<std::array<int, 2>> ListEnds(const std::vector<RestEdge>& edges) {
  std::vector<std::array<int, 2>> ends;
  for (const RestEdge& edge : edges) ends.push_back({edge.vertex[0], edge.vertex[1]});
  return ends;
}

// Multiplies the moves of the vertices of unsafe pairs by the share that is safe for them. Returns
// the vertices whose moves it has changed; empty: the moves are safe. `changed`: only pairs with
// one of these vertices are looked at; empty: all.
std::vector<bool> ShortenOnce(std::span<const PairCandidates::Candidate> near, double thickness,
                              const Eigen::VectorXd& x, const std::vector<bool>& changed,
                              Eigen::VectorXd& dx) {
  constexpr double kWithin = 0.98;  // of the share, so that the next look finds the moves safe
  std::vector<double> share(x.size() / 3, 1.0);
  bool unsafe = false;
  for (const auto& [distance, pair] : near) {
    const auto has_changed = [&](int i) { return changed[i]; };
    if (!changed.empty() && std::none_of(pair.vertex.begin(), pair.vertex.end(), has_changed))
      continue;
    const double safe =
        SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx), thickness);
    if (safe == 1.0) continue;
    unsafe = true;
    for (const int i : pair.vertex) share[i] = std::min(share[i], kWithin * safe);
  }
  if (!unsafe) return {};
  std::vector<bool> shortened(share.size());
  for (std::size_t i = 0; i < share.size(); ++i) {
    shortened[i] = share[i] < 1.0;
    dx.segment<3>(3 * static_cast<Eigen::Index>(i)) *= share[i];
  }
  return shortened;
}

}  // namespace

SelfContact::SelfContact(const Mesh& mesh, Eigen::VectorXd vertex_area, const Contact& surface)
    : surface_(surface),
      rest_x_(mesh.rest_x),
      vertex_area_(std::move(vertex_area)),
      edges_(ListEdges(mesh)),
      candidates_(ListEnds(edges_), ListTriangles(mesh), surface.thickness + surface.range) {
  CHECK_EQ(vertex_area_.size(), mesh.num_vertices());
}

bool SelfContact::ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  constexpr int kMostRounds = 30;
  candidates_.Cover(x, dx);
  const auto near = candidates_.Near(x, LongestMove(dx));
  std::vector<bool> changed;
  for (int round = 0; round < kMostRounds; ++round) {
    changed = ShortenOnce(near, surface_.thickness, x, changed, dx);
    if (changed.empty()) return round > 0;
  }
  double safe = 1.0;
  for (const auto& [distance, pair] : near)
    safe = std::min(safe, SafeShare(pair.of_edges, GatherPair(pair, x), GatherPair(pair, dx),
                                    surface_.thickness));
  dx *= safe;
  return true;
}

const RestEdge& SelfContact::EdgeBetween(int a, int b) const {
  const auto before = [](const RestEdge& edge, const std::array<int, 2>& ends) {
    return std::pair(edge.vertex[0], edge.vertex[1]) < std::pair(ends[0], ends[1]);
  };
  return *std::lower_bound(edges_.begin(), edges_.end(),
                           std::array{std::min(a, b), std::max(a, b)}, before);
}

double SelfContact::Area(const ContactPair& pair) const {
  const auto& [a, b, c, d] = pair.vertex;
  // A half, since the other side of the contact counts as well.
  return pair.of_edges ? 0.25 * (EdgeBetween(a, b).area + EdgeBetween(c, d).area)
                       : 0.5 * vertex_area_[a];
}

bool SelfContact::Pushes(const ContactPair& pair) const {
  return MeasureDistance(pair.of_edges, GatherPair(pair, rest_x_)).value >= Reach();
}

std::vector<SelfTouch> SelfContact::ListTouches(const Eigen::VectorXd& x) const {
  std::vector<SelfTouch> touches;
  for (const auto& [reference_distance, pair] : candidates_.Near(x, 0.0)) {
    const PairColumns columns = GatherPair(pair, x);
    const PairDistance distance = MeasureDistance(pair.of_edges, columns);
    if (distance.value >= Reach() || !Pushes(pair)) continue;
    SelfTouch touch{.pair = pair, .distance = distance, .area = Area(pair), .mollifier = {}};
    if (pair.of_edges) {
      const auto& [a, b, c, d] = pair.vertex;
      const double lengths = EdgeBetween(a, b).rest_length * EdgeBetween(c, d).rest_length;
      touch.mollifier = MollifyParallel(columns, lengths * lengths);
    }
    touches.push_back(touch);
  }
  return touches;
}

double SelfContact::NormalForce(const SelfTouch& touch) const {
  return -surface_.stiffness * touch.area * touch.mollifier.value *
         EvaluateBarrier(Gap(touch), surface_.range).slope;
}

double SelfContact::AddForces(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
  double energy = 0.0;
  for (const SelfTouch& touch : ListTouches(x)) {
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

void SelfContact::ForEachStiffness(const Eigen::VectorXd& x, const BlockVisitor& add) const {
  for (const SelfTouch& touch : ListTouches(x)) {
    const Eigen::Vector3d& n = touch.distance.normal;
    const Eigen::Matrix3d across = surface_.stiffness * touch.area * touch.mollifier.value *
                                   EvaluateBarrier(Gap(touch), surface_.range).curvature * n *
                                   n.transpose();
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int row = touch.pair.vertex[i], column = touch.pair.vertex[j];
        const double weight = touch.distance.weight[i] * touch.distance.weight[j];
        if (row <= column && weight != 0.0) add(row, column, weight * across);
      }
  }
}

std::vector<std::array<int, 4>> SelfContact::ListNear(const Eigen::VectorXd& x) const {
  constexpr double kSoon = 2.0;  // by the reach
  std::vector<std::array<int, 4>> near;
  for (const auto& [reference_distance, pair] : candidates_.Near(x, 0.5 * (kSoon - 1.0) * Reach()))
    if (MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kSoon * Reach() && Pushes(pair))
      near.push_back(pair.vertex);
  return near;
}

double SelfContact::SmallestGap(const Eigen::VectorXd& x) const {
  double smallest = surface_.range;
  for (const SelfTouch& touch : ListTouches(x)) smallest = std::min(smallest, Gap(touch));
  return smallest;
}

}  // namespace drape
