// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/tree_tasks.h"

#include <glog/logging.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

namespace drape {
namespace {

// The largest share of all work in a subtree that is one task: enough tasks for the threads of a
// server, so few that handing them out costs nothing.
constexpr double kLargestShare = 1.0 / 40;

// How often a thread without work looks again before it sleeps: some ten microseconds, as waking it
// takes.
constexpr int kLooks = 100;

}  // namespace

// The tasks that are ready, and the loops of tasks (ForEach), handed out to threads.
class TreeTasks::Queue {
 public:
  Queue(const std::vector<int>& rank, int tasks) : rank_(rank), left_(tasks) {}

  void Add(int task) {
    const std::lock_guard lock(mutex_);
    ready_.insert({rank_[task], task});
    changed_.notify_one();
  }
  // Returns a task, or −1 when all are done; works on the loops of others until there is one.
  int Take() {
    std::unique_lock lock(mutex_);
    for (;;) {
      Wait(lock,
           [&] { return stopped_ || left_ == 0 || !ready_.empty() || FindLoop() != nullptr; });
      if (stopped_ || left_ == 0) return -1;
      if (!ready_.empty()) {
        const int task = ready_.begin()->second;
        ready_.erase(ready_.begin());
        return task;
      }
      WorkOn(*FindLoop(), lock);
    }
  }
  // Returns whether this was the last of `count` tasks that another one waits for.
  bool IsLast(int& count) {
    const std::lock_guard lock(mutex_);
    return --count == 0;
  }
  void CountDone() {
    const std::lock_guard lock(mutex_);
    if (--left_ == 0) changed_.notify_all();
  }
  void Stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }
  bool stopped() const { return stopped_; }

  void ForEach(int count, const std::function<void(int)>& work) {
    Loop loop{&work, count, 0, count};
    std::unique_lock lock(mutex_);
    loops_.push_back(&loop);
    changed_.notify_all();
    while (loop.next < count) WorkOn(loop, lock);
    Wait(lock, [&] { return loop.left == 0; });
    loops_.erase(std::find(loops_.begin(), loops_.end(), &loop));
  }

 private:
  struct Loop {
    const std::function<void(int)>* work;
    int count, next, left;  // left: not yet finished
  };

  void Wait(std::unique_lock<std::mutex>& lock, const auto& ready) {
    for (int look = 0; look < kLooks && !ready(); ++look) {
      lock.unlock();
      std::this_thread::yield();
      lock.lock();
    }
    changed_.wait(lock, ready);
  }
  Loop* FindLoop() const {
    for (Loop* loop : loops_)
      if (loop->next < loop->count) return loop;
    return nullptr;
  }
  void WorkOn(Loop& loop, std::unique_lock<std::mutex>& lock) {
    const int i = loop.next++;
    lock.unlock();
    (*loop.work)(i);
    lock.lock();
    if (--loop.left == 0) changed_.notify_all();
  }

  const std::vector<int>& rank_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::pair<int, int>> ready_;
  std::vector<Loop*> loops_;
  int left_;  // tasks that are not done
  bool stopped_ = false;
};

void TreeTasks::Worker::ForEach(int count, const std::function<void(int)>& work) const {
  if (queue != nullptr) return queue->ForEach(count, work);
  for (int i = 0; i < count; ++i) work(i);
}

TreeTasks::TreeTasks(const std::vector<int>& parent, const std::vector<double>& work) {
  const int nodes = static_cast<int>(parent.size());
  std::vector<double> below = work;  // of the subtree
  std::vector<int> first(nodes), task_of(nodes, -1);
  std::iota(first.begin(), first.end(), 0);
  for (int s = 0; s < nodes; ++s)
    if (const int p = parent[s]; p >= 0) {
      CHECK_GT(p, s);
      below[p] += below[s];
      first[p] = std::min(first[p], first[s]);
    }
  const double largest = kLargestShare * std::accumulate(work.begin(), work.end(), 0.0);
  const auto is_small = [&](int s) { return below[s] <= largest; };
  for (int s = 0; s < nodes; ++s) {
    if (is_small(s) && parent[s] >= 0 && is_small(parent[s])) continue;  // of a larger subtree
    task_of[s] = static_cast<int>(tasks_.size());
    tasks_.push_back({is_small(s) ? first[s] : s, s, -1, 0});
  }
  const int count = static_cast<int>(tasks_.size());
  first_child_.assign(count + 1, 0);
  for (Task& task : tasks_)
    if (parent[task.last] >= 0) {
      task.parent = task_of[parent[task.last]];
      ++tasks_[task.parent].num_children;
      ++first_child_[task.parent + 1];
    }
  std::partial_sum(first_child_.begin(), first_child_.end(), first_child_.begin());
  child_.resize(first_child_.back());
  std::vector<int> next(first_child_.begin(), first_child_.end() - 1);
  std::vector<double> to_root(count);
  for (int t = count - 1; t >= 0; --t) {
    const Task& task = tasks_[t];
    to_root[t] = task.first < task.last ? below[task.last] : work[task.last];
    if (task.parent >= 0) {
      to_root[t] += to_root[task.parent];
      child_[next[task.parent]++] = t;
    }
  }
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return to_root[a] > to_root[b]; });
  rank_.resize(count);
  for (int k = 0; k < count; ++k) rank_[order[k]] = k;
}

bool TreeTasks::VisitUp(int threads, const Visit& visit) const {
  return VisitAll(threads, true, visit);
}
bool TreeTasks::VisitDown(int threads, const Visit& visit) const {
  return VisitAll(threads, false, visit);
}

bool TreeTasks::VisitAll(int threads, bool up, const Visit& visit) const {
  const int count = static_cast<int>(tasks_.size());
  if (threads <= 1) {
    for (int t = 0; t < count; ++t)
      if (!visit({0, nullptr}, tasks_[up ? t : count - 1 - t])) return false;
    return true;
  }
  Queue queue(rank_, count);
  std::vector<int> waits_for(count);
  for (int t = 0; t < count; ++t) {
    waits_for[t] = up ? tasks_[t].num_children : (tasks_[t].parent >= 0 ? 1 : 0);
    if (waits_for[t] == 0) queue.Add(t);
  }
  std::exception_ptr error;  // an exception may not leave a parallel region
#pragma omp parallel for schedule(static, 1) num_threads(threads)
  for (int thread = 0; thread < threads; ++thread) {
    try {
      for (int t = queue.Take(); t >= 0; t = queue.Take()) {
        if (!visit({thread, &queue}, tasks_[t])) queue.Stop();
        if (!up)
          for (int c = first_child_[t]; c < first_child_[t + 1]; ++c) queue.Add(child_[c]);
        else if (tasks_[t].parent >= 0 && queue.IsLast(waits_for[tasks_[t].parent]))
          queue.Add(tasks_[t].parent);
        queue.CountDone();
      }
    } catch (...) {
      queue.Stop();
#pragma omp critical(tree_tasks_error)
      error = std::current_exception();
    }
  }
  if (error) std::rethrow_exception(error);
  return !queue.stopped();
}

}  // namespace drape
