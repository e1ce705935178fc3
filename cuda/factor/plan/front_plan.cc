// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/front_plan.h"

#include <glog/logging.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "physics/util/errors.h"

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

// Pivots and border of a front, as vertices of the mesh.
struct TreeNode {
  std::vector<int> vertices;  // pivots in elimination order
  std::vector<int> border;    // later vertices that their columns of L reach, in that order
  int parent = -1;            // index of a later node; −1 at a root, which has no border
};

using Tree = std::vector<TreeNode>;

int RoundUp8(int n) { return (n + 7) / 8 * 8; }

// The place of each vertex in elimination order.
std::vector<int> EliminationPositions(const std::vector<TreeNode>& tree, int num_vertices) {
  std::vector<int> position(num_vertices, -1);
  int count = 0;
  for (const TreeNode& node : tree)
    for (const int v : node.vertices) position[v] = count++;
  CHECK_EQ(count, num_vertices);
  return position;
}

void ComputeBorders(const BlockPattern& pattern, Tree& tree) {
  const std::vector<int> position = EliminationPositions(tree, pattern.num_vertices());
  std::vector<int> seen(pattern.num_vertices(), -1);
  for (TreeNode& node : tree) node.border.clear();
  // A node's border holds, until its turn comes, what its children hand up.
  for (int i = 0; i < static_cast<int>(tree.size()); ++i) {
    TreeNode& node = tree[i];
    std::vector<int> reached;
    const int last = position[node.vertices.back()];
    const auto reach = [&](int v) {
      if (position[v] <= last || seen[v] == i) return;
      seen[v] = i;
      reached.push_back(v);
    };
    for (const int v : node.border) reach(v);
    for (const int v : node.vertices)
      for (int b = pattern.row_start[v]; b < pattern.row_start[v + 1]; ++b)
        reach(pattern.column[b]);
    std::sort(reached.begin(), reached.end(),
              [&](int a, int b) { return position[a] < position[b]; });
    node.border = std::move(reached);
    if (node.border.empty()) node.parent = -1;
    if (node.parent < 0) continue;
    std::vector<int>& up = tree[node.parent].border;
    up.insert(up.end(), node.border.begin(), node.border.end());
  }
}

// Operations of a front, and its fixed cost.
double FrontCost(std::size_t pivot_vertices, std::size_t border_vertices) {
  const double p = 3.0 * pivot_vertices, q = 3.0 * border_vertices;
  return p * p * p / 3 + p * p * q + p * q * q + 30000;
}

bool MergePays(const TreeNode& child, const TreeNode& parent, int max_vertices) {
  const std::size_t merged = child.vertices.size() + parent.vertices.size();
  return static_cast<int>(merged) <= max_vertices &&
         FrontCost(merged, parent.border.size()) <
             FrontCost(child.vertices.size(), child.border.size()) +
                 FrontCost(parent.vertices.size(), parent.border.size());
}

// Drops nodes without vertices; their children's parents have been moved on.
Tree WithoutEmptyNodes(const Tree& tree) {
  std::vector<int> index(tree.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < tree.size(); ++i)
    if (!tree[i].vertices.empty()) index[i] = count++;
  Tree kept;
  for (const TreeNode& node : tree) {
    if (node.vertices.empty()) continue;
    kept.push_back(node);
    if (node.parent >= 0) kept.back().parent = index[node.parent];
  }
  return kept;
}

// A merged front has the parent's border: the child's lies within the parent's front.
Tree Amalgamated(Tree tree, int max_vertices) {
  bool changed = true;
  while (changed) {
    changed = false;
    for (TreeNode& node : tree) {
      if (node.vertices.empty() || node.parent < 0) continue;
      while (tree[node.parent].vertices.empty()) node.parent = tree[node.parent].parent;
      TreeNode& parent = tree[node.parent];
      if (!MergePays(node, parent, max_vertices)) continue;
      parent.vertices.insert(parent.vertices.begin(), node.vertices.begin(), node.vertices.end());
      node.vertices.clear();
      changed = true;
    }
  }
  for (TreeNode& node : tree)
    while (node.parent >= 0 && tree[node.parent].vertices.empty())
      node.parent = tree[node.parent].parent;
  return WithoutEmptyNodes(tree);
}

std::int64_t PanelBytes(int pivot_vertices, int border_vertices) {
  const std::int64_t p = RoundUp8(3 * pivot_vertices), q = RoundUp8(3 * border_vertices);
  return (p + q + 8) * (p + 4) * static_cast<std::int64_t>(sizeof(double));
}

// Piece j of `count` begins at pivot vertex PieceStart.
int PieceStart(int vertices, int j, int count) {
  return static_cast<int>(static_cast<std::int64_t>(vertices) * j / count);
}

bool PiecesFit(const TreeNode& node, int count, int max_vertices, int shared_bytes) {
  const int n = static_cast<int>(node.vertices.size()), q = static_cast<int>(node.border.size());
  for (int j = 0; j < count; ++j) {
    const int end = PieceStart(n, j + 1, count), size = end - PieceStart(n, j, count);
    if (size > max_vertices || PanelBytes(size, n - end + q) > shared_bytes) return false;
  }
  return true;
}

int NumPieces(const TreeNode& node, int max_vertices, int shared_bytes) {
  const int n = static_cast<int>(node.vertices.size());
  for (int count = 1; count <= n; ++count)
    if (PiecesFit(node, count, max_vertices, shared_bytes)) return count;
  throw InputError("GPU factorisation",
                   "the mesh is too large: a front of " + std::to_string(n + node.border.size()) +
                       " vertices does not fit in " + std::to_string(shared_bytes) +
                       " bytes of shared memory");
}

Tree SplitIntoChains(const Tree& tree, int max_vertices, int shared_bytes) {
  Tree split;
  std::vector<int> first(tree.size()), last(tree.size());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const std::vector<int>& all = tree[i].vertices;
    const int n = static_cast<int>(all.size());
    const int count = NumPieces(tree[i], max_vertices, shared_bytes);
    first[i] = static_cast<int>(split.size());
    last[i] = first[i] + count - 1;
    for (int j = 0; j < count; ++j)
      split.push_back(
          {{all.begin() + PieceStart(n, j, count), all.begin() + PieceStart(n, j + 1, count)},
           {},
           first[i] + j + 1});
  }
  for (std::size_t i = 0; i < tree.size(); ++i)
    split[last[i]].parent = tree[i].parent < 0 ? -1 : first[tree[i].parent];
  return split;
}

// Rows of the front of `node` that its vertices begin at; −1 for others while it is in scope.
class FrontRows {
 public:
  FrontRows(const TreeNode& node, const Front& front, std::vector<int>& row)
      : node_(node), row_(row) {
    int k = 0;
    for (const int v : node.vertices) row_[v] = 3 * k++;
    k = 0;
    for (const int v : node.border) row_[v] = front.pivots + 3 * k++;
  }
  ~FrontRows() {
    for (const int v : node_.vertices) row_[v] = -1;
    for (const int v : node_.border) row_[v] = -1;
  }
  FrontRows(const FrontRows&) = delete;
  FrontRows& operator=(const FrontRows&) = delete;

  int of(int vertex) const { return row_[vertex]; }

 private:
  const TreeNode& node_;
  std::vector<int>& row_;
};

class Planner {
 public:
  Planner(const BlockPattern& pattern, std::vector<TreeNode> tree)
      : pattern_(pattern), tree_(std::move(tree)), row_(pattern.num_vertices(), -1) {}

  FrontPlan Run() {
    NumberVertices();
    FindChildren();
    for (const TreeNode& node : tree_) AddFront(node);
    for (int i = 0; i < num_fronts(); ++i) {
      const FrontRows rows(tree_[i], plan_.fronts[i], row_);
      AddEntries(i, rows);
      AddChildren(i, rows);
    }
    AddLevels();
    PlaceUpdates();
    return std::move(plan_);
  }

 private:
  int num_fronts() const { return static_cast<int>(tree_.size()); }

  void NumberVertices() {
    plan_.position = EliminationPositions(tree_, pattern_.num_vertices());
    plan_.vertex.resize(plan_.position.size());
    for (int v = 0; v < plan_.num_vertices(); ++v) plan_.vertex[plan_.position[v]] = v;
  }

  void FindChildren() {
    children_.resize(tree_.size());
    for (int i = 0; i < num_fronts(); ++i)
      if (tree_[i].parent >= 0) children_[tree_[i].parent].push_back(i);
  }

  void AddFront(const TreeNode& node) {
    Front front{};
    front.true_pivots = 3 * static_cast<int>(node.vertices.size());
    front.true_border = 3 * static_cast<int>(node.border.size());
    const std::int64_t p = front.pivots = RoundUp8(front.true_pivots);
    const std::int64_t q = front.border = RoundUp8(front.true_border);
    CHECK_LE(p + q, std::numeric_limits<std::int16_t>::max()) << "rows of a front";
    front.first_dof = 3 * plan_.position[node.vertices.front()];
    front.border_start = static_cast<int>(plan_.border_dof.size());
    for (const int v : node.border)
      for (int r = 0; r < 3; ++r) plan_.border_dof.push_back(3 * plan_.position[v] + r);
    plan_.border_dof.resize(front.border_start + q, -1);
    front.vector_offset = plan_.vector_size;
    plan_.vector_size += front.border;
    front.factor_offset = plan_.factor_size;
    plan_.factor_size += (p + q) * p;
    plan_.flops += p * p * p / 3.0 + p * p * q + p * q * q;
    plan_.fronts.push_back(front);
  }

  void AddEntries(int i, const FrontRows& rows) {
    plan_.fronts[i].entry_start = static_cast<int>(plan_.entries.size());
    for (const int v : tree_[i].vertices) {
      const auto column_start = plan_.entries.size();
      const int column = plan_.position[v];
      for (int b = pattern_.row_start[v]; b < pattern_.row_start[v + 1]; ++b) {
        const int w = pattern_.column[b], row = plan_.position[w];
        if (row >= column) plan_.entries.push_back({row, column, rows.of(w), rows.of(v)});
      }
      std::sort(plan_.entries.begin() + column_start, plan_.entries.end(),
                [](const FrontEntry& a, const FrontEntry& b) { return a.row < b.row; });
    }
    plan_.fronts[i].entry_end = static_cast<int>(plan_.entries.size());
  }

  void AddChildren(int i, const FrontRows& rows) {
    plan_.fronts[i].child_start = static_cast<int>(plan_.children.size());
    plan_.fronts[i].source_start = static_cast<int>(plan_.source.size());
    for (const int child : children_[i]) AddChild(plan_.fronts[i], child, rows);
    plan_.fronts[i].child_end = static_cast<int>(plan_.children.size());
  }

  void AddChild(const Front& parent, int index, const FrontRows& rows) {
    const FrontChild child{index, static_cast<int>(plan_.child_row.size())};
    plan_.child_row.resize(child.row_start + parent.pivots + parent.border, -1);
    plan_.source.resize(plan_.child_row.size(), -1);
    int from = 0;
    for (const int v : tree_[index].border) {
      CHECK_GE(rows.of(v), 0) << "the border of a child is in its parent's front";
      for (int r = 0; r < 3; ++r, ++from) {
        const int to = rows.of(v) + r;
        plan_.child_row[child.row_start + to] = static_cast<std::int16_t>(from);
        plan_.source[child.row_start + to] = plan_.fronts[index].vector_offset + from;
      }
    }
    plan_.children.push_back(child);
  }

  void AddLevels() {
    level_.assign(tree_.size(), 0);
    for (int i = 0; i < num_fronts(); ++i)
      if (const int parent = tree_[i].parent; parent >= 0)
        level_[parent] = std::max(level_[parent], level_[i] + 1);
    const auto size = [&](int i) {
      const std::int64_t p = plan_.fronts[i].pivots, q = plan_.fronts[i].border;
      return (p + q) * p + q * q;
    };
    plan_.level_front.resize(tree_.size());
    std::iota(plan_.level_front.begin(), plan_.level_front.end(), 0);
    std::stable_sort(plan_.level_front.begin(), plan_.level_front.end(), [&](int a, int b) {
      return level_[a] != level_[b] ? level_[a] < level_[b] : size(a) > size(b);
    });
    for (int k = 0; k < num_fronts(); ++k)
      if (level_[plan_.level_front[k]] == static_cast<int>(plan_.level_start.size()))
        plan_.level_start.push_back(k);
    plan_.level_start.push_back(num_fronts());
  }

  void PlaceUpdates() {
    std::vector<UpdateBlock> blocks;
    for (int i = 0; i < num_fronts(); ++i) {
      const std::int64_t q = plan_.fronts[i].border;
      const int parent = tree_[i].parent;
      blocks.push_back({(q + 1) * q, level_[i], level_[parent < 0 ? i : parent]});
    }
    const UpdateSpace space = PackUpdates(blocks);
    for (int i = 0; i < num_fronts(); ++i) plan_.fronts[i].update_offset = space.offset[i];
    plan_.update_size = space.size;
  }

  const BlockPattern& pattern_;
  const std::vector<TreeNode> tree_;
  std::vector<std::vector<int>> children_;
  std::vector<int> level_;
  std::vector<int> row_;  // of FrontRows
  FrontPlan plan_;
};

// Makes a front of each separator, merges small ones into their parents where that saves time, and
// splits large ones into chains. Children come before parents. Throws as MakeFrontPlan does.
std::vector<TreeNode> MakeAssemblyTree(const BlockPattern& pattern,
                                       const std::vector<Separator>& separators,
                                       const FrontPlanOptions& options) {
  const int max_vertices = options.max_pivots / 3;
  Tree tree;
  for (const Separator& s : separators) tree.push_back({s.vertices, {}, s.parent});
  ComputeBorders(pattern, tree);
  tree = SplitIntoChains(Amalgamated(std::move(tree), max_vertices), max_vertices,
                         options.shared_bytes);
  ComputeBorders(pattern, tree);
  return tree;
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

FrontPlan MakeFrontPlan(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv,
                        const FrontPlanOptions& options) {
  return MakeFrontPlan(pattern, NestedDissection(pattern, uv, options.dissection), options);
}

FrontPlan MakeFrontPlan(const BlockPattern& pattern, const std::vector<Separator>& separators,
                        const FrontPlanOptions& options) {
  CHECK(options.max_pivots >= 3 && options.max_pivots <= 64);
  return Planner(pattern, MakeAssemblyTree(pattern, separators, options)).Run();
}

Mesh Renumber(const Mesh& mesh, const FrontPlan& plan) {
  CHECK_EQ(mesh.num_vertices(), plan.num_vertices());
  Mesh result = mesh;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    result.uv.col(plan.position[v]) = mesh.uv.col(v);
    result.rest_x.segment<3>(3 * plan.position[v]) = mesh.rest_x.segment<3>(3 * v);
  }
  for (Face& face : result.faces)
    for (int& v : face.vertex) v = plan.position[v];
  for (Hinge& hinge : result.hinges)
    for (int& v : hinge.vertex) v = plan.position[v];
  for (auto& loop : result.boundary_loops)
    for (int& v : loop) v = plan.position[v];
  return result;
}

}  // namespace drape
