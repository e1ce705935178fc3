// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/box_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace drape {
namespace {

// More than a number of double precision changes when it is rounded to single precision.
double Rounding(double number) { return 1e-7 * (std::abs(number) + 1.0); }

}  // namespace

BoxTree::RoundedBox BoxTree::Rounded(const SpaceBox& box) {
  RoundedBox rounded;
  for (int k = 0; k < 3; ++k) {
    rounded.low[k] = static_cast<float>(box.low[k] - Rounding(box.low[k]));
    rounded.high[k] = static_cast<float>(box.high[k] + Rounding(box.high[k]));
  }
  return rounded;
}

BoxTree::RoundedBox BoxTree::BoxAt(int place) const {
  const Node& node = node_[place / kChildren];
  RoundedBox box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = node.low[k][place % kChildren];
    box.high[k] = node.high[k][place % kChildren];
  }
  return box;
}

void BoxTree::Put(int level, int place, const RoundedBox& box) {
  Node& node = node_[level_start_[level] + place / kChildren];
  for (int k = 0; k < 3; ++k) {
    node.low[k][place % kChildren] = box.low[k];
    node.high[k][place % kChildren] = box.high[k];
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
      for (int k = 0; k < 3; ++k) {
        around.low[k] = kNone;
        around.high[k] = -kNone;
        for (int child = 0; child < kChildren; ++child) {
          around.low[k] = std::min(around.low[k], node_[i].low[k][child]);
          around.high[k] = std::max(around.high[k], node_[i].high[k][child]);
        }
      }
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
  std::array<double, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = boxes[order_[begin]].low[k];
    high[k] = boxes[order_[begin]].high[k];
    for (int i = begin + 1; i < end; ++i) {
      low[k] = std::min(low[k], boxes[order_[i]].low[k]);
      high[k] = std::max(high[k], boxes[order_[i]].high[k]);
    }
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int a, int b) {
                     const double of_a = boxes[a].low[axis] + boxes[a].high[axis],
                                  of_b = boxes[b].low[axis] + boxes[b].high[axis];
                     return of_a < of_b || (of_a == of_b && a < b);
                   });
  Sort(boxes, begin, middle);
  Sort(boxes, middle, end);
}

}  // namespace drape
