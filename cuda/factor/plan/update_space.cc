// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/update_space.h"

#include <algorithm>
#include <numeric>

namespace drape {
namespace {

struct Used {
  std::int64_t start, end;
  int last;
};

// Takes the first gap of `size` in `used`, which is sorted.
std::int64_t Insert(std::vector<Used>& used, std::int64_t size, int last) {
  std::int64_t start = 0;
  auto next = used.begin();
  for (; next != used.end() && next->start - start < size; ++next) start = next->end;
  used.insert(next, {start, start + size, last});
  return start;
}

}  // namespace

UpdateSpace PackUpdates(const std::vector<UpdateBlock>& blocks) {
  std::vector<int> order(blocks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return blocks[a].first != blocks[b].first ? blocks[a].first < blocks[b].first
                                              : blocks[a].size > blocks[b].size;
  });
  UpdateSpace space;
  space.offset.resize(blocks.size());
  std::vector<Used> used;
  for (const int i : order) {
    std::erase_if(used, [&](const Used& u) { return u.last < blocks[i].first; });
    space.offset[i] = Insert(used, blocks[i].size, blocks[i].last);
    space.size = std::max(space.size, space.offset[i] + blocks[i].size);
  }
  return space;
}

}  // namespace drape
