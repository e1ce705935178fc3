// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

namespace drape {

// An axis-parallel box, bounds included [m].
struct SpaceBox {
  std::array<double, 3> low, high;

  bool Meets(const SpaceBox& other) const {
    bool meets = true;
    for (int k = 0; k < 3; ++k) meets &= low[k] <= other.high[k] && other.low[k] <= high[k];
    return meets;
  }
};

// A balanced binary tree of boxes, which finds those that meet another. Boxes that move are
// enclosed again without another order, so that it stays good while neighbours stay neighbours.
class BoxTree {
 public:
  // From now on, of these boxes. Those of a number of boxes that it had before keep their order.
  void Enclose(const std::vector<SpaceBox>& boxes);

  // Calls visit(k) for the number of each box that meets this one, in no particular order.
  template <class Visit>
  void ForEachMeeting(const SpaceBox& box, const Visit& visit) const {
    if (order_.empty()) return;
    std::array<Range, kMostDepth> open;
    int count = 0;
    open[count++] = {0, 0, static_cast<int>(order_.size())};
    while (count > 0) {
      const Range range = open[--count];
      if (!node_[range.node].Meets(box)) continue;
      if (range.end - range.begin <= kLeaf) {
        for (int i = range.begin; i < range.end; ++i)
          if (box_[i].Meets(box)) visit(order_[i]);
        continue;
      }
      const auto [left, right] = Halves(range);
      open[count++] = right;
      open[count++] = left;
    }
  }

 private:
  static constexpr int kLeaf = 4, kMostDepth = 64;
  // A node and the places in the order that it covers.
  struct Range {
    int node, begin, end;
  };
  static std::pair<Range, Range> Halves(const Range& range) {
    const int middle = range.begin + (range.end - range.begin) / 2;
    return {{2 * range.node + 1, range.begin, middle}, {2 * range.node + 2, middle, range.end}};
  }
  void Sort(const std::vector<SpaceBox>& boxes, const Range& range);
  void Refit(const Range& range);

  std::vector<int> order_;      // the numbers of the boxes
  std::vector<SpaceBox> box_;   // in this order
  std::vector<SpaceBox> node_;  // around the boxes of each node
};

}  // namespace drape
