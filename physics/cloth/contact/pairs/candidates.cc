// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/candidates.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace drape {
namespace {

constexpr double kSlack = 5e-4;  // of the boxes around vertices [m]

}  // namespace

double LongestMove(const Eigen::VectorXd& dx) {
  return dx.size() == 0 ? 0.0 : dx.reshaped(3, dx.size() / 3).colwise().norm().maxCoeff();
}

PairCandidates::PairCandidates(SurfaceParts cloth, double reach, bool of_cloth)
    : cloth_(std::move(cloth)), reach_(reach), of_cloth_(of_cloth) {}

void PairCandidates::SetObstacles(SurfaceParts obstacles, double reach) {
  obstacles_ = BoxedSurface(std::move(obstacles));
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
  // From the reference shape to any corner of a box.
  const Eigen::VectorXd ways =
      dx.reshaped(3, vertices).colwise().norm().transpose().array() + std::sqrt(3.0) * kSlack;
  cloth_.Enclose(known_, 0.5 * reach_, threads_);
  if (of_cloth_) AddCandidates(ListPairsWithin(cloth_, threads_), x, ways);
  if (!obstacles_.parts().vertices.empty()) {
    obstacles_.Enclose(known_, 0.5 * reach_, threads_);
    AddCandidates(ListPairsBetween(cloth_, obstacles_, threads_), x, ways);
  }
  std::sort(candidates_.begin(), candidates_.end());
}

void PairCandidates::AddCandidates(const std::vector<ContactPair>& pairs, const Eigen::VectorXd& x,
                                   const Eigen::VectorXd& ways) {
  std::vector<double> distances(pairs.size());
#pragma omp parallel for num_threads(threads_) if (threads_ > 1)
  for (std::size_t k = 0; k < pairs.size(); ++k)
    distances[k] = MeasureDistance(pairs[k].of_edges, GatherPair(pairs[k], x)).value;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const std::array<int, 4>& i = pairs[k].vertex;
    const int of_first = pairs[k].of_edges ? 2 : 1;
    double first = 0.0, second = 0.0;
    for (int j = 0; j < 4; ++j)
      (j < of_first ? first : second) = std::max(j < of_first ? first : second, ways[i[j]]);
    if (distances[k] < reach_ + first + second) candidates_.push_back({distances[k], pairs[k]});
  }
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
