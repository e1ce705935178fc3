// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/box_tree.h"

#include <algorithm>
#include <numeric>

namespace drape {
namespace {

SpaceBox Around(const SpaceBox& a, const SpaceBox& b) {
  SpaceBox box = a;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::min(box.low[k], b.low[k]);
    box.high[k] = std::max(box.high[k], b.high[k]);
  }
  return box;
}

}  // namespace

void BoxTree::Enclose(const std::vector<SpaceBox>& boxes) {
  const Range all{0, 0, static_cast<int>(boxes.size())};
  if (order_.size() != boxes.size()) {
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0);
    Sort(boxes, all);
  }
  if (boxes.empty()) return;
  box_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) box_[i] = boxes[order_[i]];
  std::size_t nodes = 1;
  while (nodes * kLeaf < boxes.size()) nodes *= 2;
  node_.resize(2 * nodes);
  Refit(all);
}

// Halves the boxes where they extend furthest.
void BoxTree::Sort(const std::vector<SpaceBox>& boxes, const Range& range) {
  if (range.end - range.begin <= kLeaf) return;
  const auto begin = order_.begin() + range.begin, end = order_.begin() + range.end;
  SpaceBox all = boxes[*begin];
  for (auto it = begin; it != end; ++it) all = Around(all, boxes[*it]);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (all.high[k] - all.low[k] > all.high[axis] - all.low[axis]) axis = k;
  const auto [left, right] = Halves(range);
  std::nth_element(begin, order_.begin() + left.end, end, [&](int a, int b) {
    const double of_a = boxes[a].low[axis] + boxes[a].high[axis],
                 of_b = boxes[b].low[axis] + boxes[b].high[axis];
    return of_a < of_b || (of_a == of_b && a < b);
  });
  Sort(boxes, left);
  Sort(boxes, right);
}

void BoxTree::Refit(const Range& range) {
  SpaceBox& node = node_[range.node];
  if (range.end - range.begin <= kLeaf) {
    node = box_[range.begin];
    for (int i = range.begin + 1; i < range.end; ++i) node = Around(node, box_[i]);
    return;
  }
  const auto [left, right] = Halves(range);
  Refit(left);
  Refit(right);
  node = Around(node_[left.node], node_[right.node]);
}

}  // namespace drape
