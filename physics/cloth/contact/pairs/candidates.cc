// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/candidates.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace drape {
namespace {

// More than numbers of double precision change when they are rounded to single precision.
Eigen::Vector3d Rounding(const Eigen::Array3d& numbers) { return 1e-7 * (numbers.abs() + 1.0); }

// The boxes around parts of a surface, each `more` [m] larger on all sides.
template <std::size_t N>
void EncloseParts(const std::vector<std::array<int, N>>& parts, const VertexBoxes& boxes,
                  double more, int threads, std::vector<SpaceBox>& all) {
  all.resize(parts.size());
#pragma omp parallel for num_threads(threads) if (threads > 1)
  for (std::size_t k = 0; k < parts.size(); ++k) {
    all[k].setEmpty();
    for (const int i : parts[k]) all[k].extend(SpaceBox(boxes.low.col(i), boxes.high.col(i)));
    all[k].min().array() -= more;
    all[k].max().array() += more;
  }
}

// All that list(k, pairs) adds for k < count, in the order of k.
template <class List>
void Collect(int count, int threads, const List& list, std::vector<ContactPair>& pairs) {
  constexpr int kChunk = 64;
  const int chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::vector<ContactPair>> found(chunks);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
  for (int c = 0; c < chunks; ++c)
    for (int k = kChunk * c; k < std::min(count, kChunk * (c + 1)); ++k) list(k, found[c]);
  for (const std::vector<ContactPair>& part : found)
    pairs.insert(pairs.end(), part.begin(), part.end());
}

// Each vertex of one surface and the triangles of another.
void AddVerticesAndTriangles(const BoxedSurface& one, const BoxedSurface& other, int threads,
                             std::vector<ContactPair>& pairs) {
  const auto list = [&](int k, std::vector<ContactPair>& found) {
    const int i = one.parts.vertices[k];
    other.triangle_tree.ForEachMeeting(one.vertices[k], [&](int triangle) {
      const auto& [p, q, r] = other.parts.triangles[triangle];
      if (i != p && i != q && i != r) found.push_back({false, {i, p, q, r}});
    });
  };
  Collect(static_cast<int>(one.vertices.size()), threads, list, pairs);
}

constexpr double kSlack = 5e-4;  // of the boxes around vertices [m]

// All pairs of a cloth whose boxes meet, in the same order with any number of threads. Pairs with a
// common vertex are none.
std::vector<ContactPair> ListPairsWithin(const BoxedSurface& cloth, int threads) {
  std::vector<ContactPair> pairs;
  AddVerticesAndTriangles(cloth, cloth, threads, pairs);
  const auto list = [&](int place, std::vector<ContactPair>& found) {
    const int one = cloth.edge_tree.order()[place];
    cloth.edge_tree.ForEachLaterMeeting(place, [&](int other) {
      const auto& [p, q] = cloth.parts.edges[std::min(one, other)];
      const auto& [r, s] = cloth.parts.edges[std::max(one, other)];
      if (p != r && p != s && q != r && q != s) found.push_back({true, {p, q, r, s}});
    });
  };
  Collect(static_cast<int>(cloth.edges.size()), threads, list, pairs);
  return pairs;
}

// All such pairs of a part of a cloth and one of an obstacle, which have no vertex in common. Of
// edges, the cloth's edge comes first.
std::vector<ContactPair> ListPairsBetween(const BoxedSurface& cloth, const BoxedSurface& obstacle,
                                          int threads) {
  std::vector<ContactPair> pairs;
  AddVerticesAndTriangles(cloth, obstacle, threads, pairs);
  AddVerticesAndTriangles(obstacle, cloth, threads, pairs);
  const auto list = [&](int k, std::vector<ContactPair>& found) {
    const std::array<int, 2>& edge = cloth.parts.edges[k];
    obstacle.edge_tree.ForEachMeeting(cloth.edges[k], [&](int other) {
      const auto& [r, s] = obstacle.parts.edges[other];
      found.push_back({true, {edge[0], edge[1], r, s}});
    });
  };
  Collect(static_cast<int>(cloth.edges.size()), threads, list, pairs);
  return pairs;
}

}  // namespace

BoxTree::RoundedBox BoxTree::Rounded(const SpaceBox& box) {
  return {(box.min() - Rounding(box.min())).cast<float>(),
          (box.max() + Rounding(box.max())).cast<float>()};
}

BoxTree::RoundedBox BoxTree::BoxAt(int place) const {
  const Node& node = node_[place / kChildren];
  RoundedBox box;
  for (int k = 0; k < 3; ++k) {
    box.min()[k] = node.low[k][place % kChildren];
    box.max()[k] = node.high[k][place % kChildren];
  }
  return box;
}

void BoxTree::Put(int level, int place, const RoundedBox& box) {
  Node& node = node_[level_start_[level] + place / kChildren];
  for (int k = 0; k < 3; ++k) {
    node.low[k][place % kChildren] = box.min()[k];
    node.high[k][place % kChildren] = box.max()[k];
  }
}

void BoxTree::Enclose(const std::vector<SpaceBox>& boxes) {
  const int count = static_cast<int>(boxes.size());
  if (order_.size() != boxes.size()) {
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0);
    Sort(boxes, 0, count);
    level_start_.clear();
    int nodes = 0;
    for (int below = count; nodes == 0 || below > 1;) {
      below = (below + kChildren - 1) / kChildren;
      level_start_.push_back(nodes);
      nodes += below;
    }
    node_.resize(nodes);
  }
  constexpr float kNone = std::numeric_limits<float>::infinity();
  const Floats none = Floats{} + kNone;
  for (Node& node : node_) node = {{none, none, none}, {-none, -none, -none}};
  for (int place = 0; place < count; ++place) Put(0, place, Rounded(boxes[order_[place]]));
  for (std::size_t level = 0; level + 1 < level_start_.size(); ++level)
    for (int i = level_start_[level]; i < level_start_[level + 1]; ++i) {
      RoundedBox around;
      for (int child = 0; child < kChildren; ++child) around.extend(BoxAt(kChildren * i + child));
      Put(static_cast<int>(level) + 1, i - level_start_[level], around);
    }
}

// Halves the boxes where they extend furthest, between two children of the node around them.
void BoxTree::Sort(const std::vector<SpaceBox>& boxes, int begin, int end) {
  if (end - begin <= kChildren) return;
  int of_child = kChildren;
  while (of_child * kChildren < end - begin) of_child *= kChildren;
  const int children = (end - begin + of_child - 1) / of_child;
  const int middle = begin + of_child * (children / 2);
  SpaceBox around;
  for (int i = begin; i < end; ++i) around.extend(boxes[order_[i]]);
  int axis = 0;
  around.sizes().maxCoeff(&axis);
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int a, int b) {
                     const double of_a = boxes[a].min()[axis] + boxes[a].max()[axis],
                                  of_b = boxes[b].min()[axis] + boxes[b].max()[axis];
                     return of_a < of_b || (of_a == of_b && a < b);
                   });
  Sort(boxes, begin, middle);
  Sort(boxes, middle, end);
}

void BoxedSurface::Enclose(const VertexBoxes& boxes, double more, int threads) {
  std::vector<std::array<int, 1>> singles;
  singles.reserve(parts.vertices.size());
  for (const int i : parts.vertices) singles.push_back({i});
  EncloseParts(singles, boxes, more, threads, vertices);
  EncloseParts(parts.edges, boxes, more, threads, edges);
  EncloseParts(parts.triangles, boxes, more, threads, triangles);
  edge_tree.Enclose(edges);
  triangle_tree.Enclose(triangles);
}

Eigen::VectorXd Joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  Eigen::VectorXd joined(a.size() + b.size());
  joined << a, b;
  return joined;
}

double LongestMove(const Eigen::VectorXd& dx) {
  return dx.size() == 0 ? 0.0 : dx.reshaped(3, dx.size() / 3).colwise().norm().maxCoeff();
}

PairCandidates::PairCandidates(SurfaceParts cloth, double reach, bool of_cloth)
    : cloth_{.parts = std::move(cloth)}, reach_(reach), of_cloth_(of_cloth) {}

void PairCandidates::SetObstacles(SurfaceParts obstacles, double reach) {
  obstacles_ = {.parts = std::move(obstacles)};
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
  if (!obstacles_.parts.vertices.empty()) {
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
