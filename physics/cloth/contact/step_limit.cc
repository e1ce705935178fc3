// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/step_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace drape {
namespace {

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
