// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/candidates.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

namespace drape {
namespace {

constexpr double kSlack = 1e-3;  // of the boxes around vertices [m]

}  // namespace

double LongestMove(const Eigen::VectorXd& dx) {
  return dx.size() == 0 ? 0.0 : dx.reshaped(3, dx.size() / 3).colwise().norm().maxCoeff();
}

PairCandidates::PairCandidates(SurfaceParts cloth, double reach, bool of_cloth)
    : cloth_(std::move(cloth)), reach_(reach), of_cloth_(of_cloth) {}

void PairCandidates::SetObstacles(SurfaceParts obstacles, double reach) {
  obstacles_ = std::move(obstacles);
  reach_ = reach;
  known_ = {};
}

bool PairCandidates::Covers(const Eigen::VectorXd& x) const {
  if (known_.low.size() != x.size()) return false;
  const auto places = x.reshaped(3, x.size() / 3).array();
  return (places >= known_.low.array()).all() && (places <= known_.high.array()).all();
}

void PairCandidates::Cover(const Eigen::VectorXd& x, const Eigen::VectorXd& dx) {
  const Eigen::VectorXd to = x + dx;
  if (Covers(x) && Covers(to) && LongestMove(x - reference_) <= kSlack) return;
  reference_ = x;
  const Eigen::Index vertices = x.size() / 3;
  known_.low = x.cwiseMin(to).reshaped(3, vertices).array() - kSlack;
  known_.high = x.cwiseMax(to).reshaped(3, vertices).array() + kSlack;
  candidates_.clear();
  const auto add = [&](const std::vector<ContactPair>& pairs) {
    for (const ContactPair& pair : pairs)
      candidates_.push_back({MeasureDistance(pair.of_edges, GatherPair(pair, x)).value, pair});
  };
  if (of_cloth_) add(ListPairsWithin(cloth_, known_, reach_));
  if (!obstacles_.vertices.empty()) add(ListPairsBetween(cloth_, obstacles_, known_, reach_));
  std::sort(candidates_.begin(), candidates_.end());
}

std::span<const PairCandidates::Candidate> PairCandidates::Near(const Eigen::VectorXd& x,
                                                                double move) const {
  CHECK(Covers(x));
  const double most = reach_ + 2.0 * (LongestMove(x - reference_) + move);
  const auto end = std::partition_point(candidates_.begin(), candidates_.end(),
                                        [&](const Candidate& c) { return c.distance < most; });
  return {candidates_.begin(), end};
}

}  // namespace drape
