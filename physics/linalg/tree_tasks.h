// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace drape {

// Work on the nodes of a forest by several threads, children before parents or the reverse. Small
// subtrees are tasks of one thread; each node above them is a task of its own. The tasks do not
// depend on the number of threads.
class TreeTasks {
 public:
  struct Task {
    int first, last;  // the nodes of a subtree with the root `last`, or one node
    int parent;       // task; −1 of a root
    int num_children;
  };
  // parent: [S], greater than the node, or −1; descendants of a node directly precede it.
  // work: [S], of each node.
  TreeTasks(const std::vector<int>& parent, const std::vector<double>& work);

  const std::vector<Task>& tasks() const { return tasks_; }

  // Who visits a task.
  class Queue;
  struct Worker {
    int thread;    // 0 … threads − 1
    Queue* queue;  // null where there is one thread

    // Calls work(i) for 0 ≤ i < count, on this thread and on those that have no task just now.
    // work throws nothing.
    void ForEach(int count, const std::function<void(int)>& work) const;
  };

  // Calls visit(worker, task) for every task after its children's, or after its parent's. Ends soon
  // after a call returned false, and returns false then.
  using Visit = std::function<bool(const Worker& worker, const Task& task)>;
  bool VisitUp(int threads, const Visit& visit) const;
  bool VisitDown(int threads, const Visit& visit) const;

 private:
  bool VisitAll(int threads, bool up, const Visit& visit) const;

  std::vector<Task> tasks_;               // children before parents
  std::vector<int> first_child_, child_;  // of tasks
  std::vector<int> rank_;                 // of a task: those with more work up to the root first
};

}  // namespace drape
