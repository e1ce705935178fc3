// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "physics/linalg/supernodal_factor.h"

namespace drape {
namespace {

// A binary tree of this depth in postorder.
int AppendTree(int depth, std::vector<int>& parent) {
  std::vector<int> children;
  if (depth > 1)
    for (int side = 0; side < 2; ++side) children.push_back(AppendTree(depth - 1, parent));
  const int root = static_cast<int>(parent.size());
  parent.push_back(-1);
  for (const int child : children) parent[child] = root;
  return root;
}

class TreeTasksTest : public testing::Test {
 protected:
  static std::vector<int> MakeForest() {
    std::vector<int> parent;
    AppendTree(8, parent);
    AppendTree(3, parent);
    parent.push_back(-1);
    return parent;
  }
  const std::vector<int> parent_ = MakeForest();
  const TreeTasks tasks_{parent_, std::vector<double>(parent_.size(), 1.0)};
};

TEST_F(TreeTasksTest, TasksAreSubtreesBelowSingleNodes) {
  std::vector<int> covered(parent_.size());
  int subtrees = 0;
  for (const TreeTasks::Task& task : tasks_.tasks()) {
    for (int s = task.first; s <= task.last; ++s) {
      ++covered[s];
      EXPECT_TRUE(s == task.last || parent_[s] <= task.last);
    }
    subtrees += task.first < task.last;
  }
  EXPECT_THAT(covered, testing::Each(1));
  EXPECT_GT(subtrees, 8);
}

TEST_F(TreeTasksTest, ChildrenComeFirstUpAndLastDown) {
  for (const int threads : {1, 2, 5})
    for (const bool up : {true, false}) {
      SCOPED_TRACE(testing::Message() << threads << (up ? ", up" : ", down"));
      std::vector<std::atomic<int>> done(parent_.size());
      std::atomic<int> wrong = 0;
      const auto visit = [&](const TreeTasks::Worker& worker, const TreeTasks::Task& task) {
        wrong += worker.thread < 0 || worker.thread >= threads;
        for (int s = 0; s < task.first; ++s)  // the nodes outside the task that it depends on
          if (up && parent_[s] >= task.first && parent_[s] <= task.last) wrong += done[s] != 1;
        if (const int p = parent_[task.last]; !up && p >= 0) wrong += done[p] != 1;
        // So that the others take tasks meanwhile.
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        for (int s = task.first; s <= task.last; ++s) ++done[s];
        return true;
      };
      EXPECT_TRUE(up ? tasks_.VisitUp(threads, visit) : tasks_.VisitDown(threads, visit));
      EXPECT_EQ(wrong, 0);
      for (const auto& count : done) EXPECT_EQ(count, 1);
    }
}

TEST_F(TreeTasksTest, LoopsOfATaskAreSharedAndEndWithin) {
  for (const int threads : {1, 2, 5}) {
    std::atomic<int> wrong = 0;
    tasks_.VisitUp(threads, [&](const TreeTasks::Worker& worker, const TreeTasks::Task&) {
      std::vector<int> calls(50);
      worker.ForEach(50, [&](int i) { ++calls[i]; });
      for (const int count : calls) wrong += count != 1;
      return true;
    });
    EXPECT_EQ(wrong, 0) << threads;
  }
}

TEST_F(TreeTasksTest, EndsAfterARefusalAndPassesErrorsOn) {
  for (const int threads : {1, 3}) {
    std::atomic<int> calls = 0;
    EXPECT_FALSE(tasks_.VisitUp(threads, [&](const TreeTasks::Worker&, const TreeTasks::Task&) {
      ++calls;
      return false;
    }));
    EXPECT_LE(calls, threads);
    EXPECT_THROW(tasks_.VisitUp(threads,
                                [](const TreeTasks::Worker&, const TreeTasks::Task& task) {
                                  if (task.last > 100) throw std::runtime_error("full");
                                  return true;
                                }),
                 std::runtime_error);
  }
}

}  // namespace
}  // namespace drape
