// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/gather_list.h"

#include <glog/logging.h>

#include <algorithm>
#include <numeric>
#include <utility>

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

constexpr int kMaxElements = 1 << 26;  // of a kind: what Contribution::Pack has room for

// Calls add(target, contribution) faces first, each kind by ascending element. `target` gives the
// index that corners (row, column) of an element add to, −1 where there is none.
template <class Target, class Add>
void ForEach(const Mesh& mesh, const Scene& scene, Target&& target, Add&& add) {
  const auto visit = [&](const auto& elements, int corners, bool hinge) {
    for (int e = 0; e < static_cast<int>(elements.size()); ++e)
      for (int row = 0; row < corners; ++row)
        for (int column = 0; column < corners; ++column) {
          const Contribution contribution{e, hinge, row, column};
          if (const int to = target(elements[e].vertex, contribution); to >= 0)
            add(to, contribution.Pack());
        }
  };
  if (scene.stretch) visit(mesh.faces, 3, false);
  if (scene.bend) visit(mesh.hinges, 4, true);
}

template <class Target>
GatherList Gather(const Mesh& mesh, const Scene& scene, int num_targets, Target&& target) {
  CHECK(mesh.num_faces() < kMaxElements && mesh.num_hinges() < kMaxElements);
  GatherList list;
  list.start.assign(num_targets + 1, 0);
  ForEach(mesh, scene, target, [&](int to, int) { ++list.start[to + 1]; });
  for (int i = 0; i < num_targets; ++i) list.start[i + 1] += list.start[i];
  list.item.resize(list.start.back());
  std::vector<int> next = list.start;
  ForEach(mesh, scene, target, [&](int to, int item) { list.item[next[to]++] = item; });
  return list;
}

int FindEntry(const FrontPlan& plan, int row, int column) {
  const auto key = [](const FrontEntry& e) { return std::pair(e.column, e.row); };
  const auto it = std::lower_bound(
      plan.entries.begin(), plan.entries.end(), std::pair(column, row),
      [&](const FrontEntry& entry, const auto& wanted) { return key(entry) < wanted; });
  CHECK(it != plan.entries.end() && key(*it) == std::pair(column, row))
      << "the plan's pattern lacks block " << row << ", " << column;
  return static_cast<int>(it - plan.entries.begin());
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

GatherList GatherEntries(const FrontPlan& plan, const Mesh& mesh, const Scene& scene) {
  const int count = static_cast<int>(plan.entries.size());
  return Gather(mesh, scene, count, [&](const int* vertex, const Contribution& c) {
    const int row = vertex[c.row], column = vertex[c.column];
    return row < column ? -1 : FindEntry(plan, row, column);
  });
}

GatherList GatherVertices(const Mesh& mesh, const Scene& scene) {
  return Gather(mesh, scene, mesh.num_vertices(), [](const int* vertex, const Contribution& c) {
    return c.row == c.column ? vertex[c.row] : -1;
  });
}

std::vector<int> OrderByWork(const GatherList& list, int chunk) {
  std::vector<int> order(list.start.size() - 1);
  std::iota(order.begin(), order.end(), 0);
  const auto end = order.end();
  for (auto from = order.begin(); from != end; from += std::min<std::ptrdiff_t>(chunk, end - from))
    std::stable_sort(from, from + std::min<std::ptrdiff_t>(chunk, end - from), [&](int a, int b) {
      return list.start[a + 1] - list.start[a] > list.start[b + 1] - list.start[b];
    });
  return order;
}

std::vector<int> DiagonalEntries(const FrontPlan& plan) {
  std::vector<int> diagonal(plan.num_vertices());
  for (int i = 0; i < plan.num_vertices(); ++i) diagonal[i] = FindEntry(plan, i, i);
  return diagonal;
}

}  // namespace drape
