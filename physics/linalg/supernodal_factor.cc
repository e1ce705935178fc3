// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/supernodal_factor.h"

#include <glog/logging.h>

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <mutex>
#include <new>
#include <numeric>
#include <set>
#include <thread>
#include <utility>

namespace drape {
namespace {

// The largest share of all work in a subtree that is one task: enough tasks for the threads of a
// server, so few that handing them out costs nothing.
constexpr double kLargestShare = 1.0 / 40;

// How often a thread without work looks again before it sleeps: some ten microseconds, as waking it
// takes.
constexpr int kLooks = 100;

constexpr std::align_val_t kCacheLine{64};
constexpr int kAhead = 128;                   // numbers of A
constexpr std::ptrdiff_t kPrefetched = 8192;  // numbers of L
constexpr int kPanelColumns = 64;
constexpr int kPartColumns = 24;      // of a part of a product that another thread may take
constexpr double kSharedFlops = 2e6;  // handing out a smaller product takes longer than it gains

// Calls part(first, last) for the columns begin … end, in parts for other threads where that pays.
void ForEachPart(const TreeTasks::Worker& worker, int begin, int end, double flops,
                 const auto& part) {
  if (begin >= end) return;
  if (worker.queue == nullptr || flops < kSharedFlops) return part(begin, end);
  worker.ForEach((end - begin + kPartColumns - 1) / kPartColumns, [&](int i) {
    const int first = begin + i * kPartColumns;
    part(first, std::min(first + kPartColumns, end));
  });
}

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

void AlignedNumbers::Free::operator()(double* data) const { ::operator delete[](data, kCacheLine); }

void AlignedNumbers::Resize(std::size_t size) {
  if (size <= size_) return;
  data_.reset();
  size_ = 0;
  data_.reset(static_cast<double*>(::operator new[](size * sizeof(double), kCacheLine)));
  size_ = size;
}

struct SupernodalFactor::Front {
  const double* a;
  double* number;
  double *panel, *subtree, *shared;  // shared: null where there is one thread
};

SupernodalFactor::SupernodalFactor(SupernodalPattern pattern, const LowerTriangle& lower,
                                   const FrontKernels& kernels)
    : pattern_(std::move(pattern)),
      plan_(MakeFactorPlan(pattern_, lower)),
      tasks_(plan_.parent, plan_.work),
      kernels_(&kernels) {
  PlaceTasks();
}

void SupernodalFactor::PlaceTasks() {
  const int supernodes = pattern_.num_supernodes();
  std::vector<std::ptrdiff_t> matrices, vectors;
  for (int s = 0; s < supernodes; ++s) {
    const std::ptrdiff_t rows = UpdateMatrix::Padded(pattern_.num_rows(s));
    matrices.push_back(UpdateMatrix::NumNumbers(pattern_.num_below(s)));
    vectors.push_back(rows);
    vector_place_.push_back(static_cast<std::ptrdiff_t>(shared_size_));
    shared_size_ += rows;
    panel_size_ =
        std::max(panel_size_, static_cast<std::size_t>(rows) * pattern_.width(s) + kMargin);
  }
  place_.resize(supernodes);
  is_shared_.assign(supernodes, 0);
  std::size_t shared_matrices = 0, size = 0;
  for (const TreeTasks::Task& task : tasks_.tasks()) {
    const std::vector<std::ptrdiff_t> place =
        PlacePassed(plan_, matrices, task.first, task.last - 1, &size);
    std::copy(place.begin(), place.end(), place_.begin() + task.first);
    subtree_size_ = std::max(subtree_size_, size);
    place_[task.last] = static_cast<std::ptrdiff_t>(shared_matrices);
    is_shared_[task.last] = 1;
    shared_matrices += matrices[task.last];
  }
  shared_size_ = std::max(shared_size_, shared_matrices);
  place_alone_ = PlacePassed(plan_, matrices, 0, supernodes - 1, &alone_size_);
  vector_place_alone_ = PlacePassed(plan_, vectors, 0, supernodes - 1, &size);
  alone_size_ = std::max(alone_size_, size);
}

std::size_t SupernodalFactor::num_numbers() const {
  return static_cast<std::size_t>(pattern_.first_number.back());
}

UpdateMatrix SupernodalFactor::GetUpdateMatrix(const Front& front, int s) const {
  const int below = pattern_.num_below(s);
  if (front.shared == nullptr) return {front.subtree + place_alone_[s], below};
  return {(is_shared_[s] ? front.shared : front.subtree) + place_[s], below};
}

bool SupernodalFactor::FactorPanel(const FrontPanel& panel, const TreeTasks::Worker& worker) const {
  for (int begin = 0; begin < panel.width; begin += kPanelColumns) {
    const int end = std::min(begin + kPanelColumns, panel.width);
    if (!kernels_->factor_columns(panel, begin, end)) return false;
    const double flops = 2.0 * kPanelColumns * (panel.width - end) * (panel.rows - end);
    ForEachPart(worker, end, panel.width, flops, [&](int first, int last) {
      kernels_->subtract_columns(panel, begin, end, first, last);
    });
  }
  return true;
}

bool SupernodalFactor::FactorFront(const Front& front, int s,
                                   const TreeTasks::Worker& worker) const {
  const int rows = pattern_.num_rows(s), width = pattern_.width(s);
  const FrontPanel panel{front.panel, UpdateMatrix::Padded(rows), rows, width};
  std::memset(panel.number, 0,
              (static_cast<std::size_t>(panel.stride) * width + kMargin) * sizeof(double));
  const FactorPlan::Entry* const entry = plan_.entry.data();
  const int last_entry = plan_.first_entry[s + 1], all_entries = plan_.first_entry.back();
  for (int e = plan_.first_entry[s]; e < last_entry; ++e) {
    __builtin_prefetch(front.a + entry[std::min(e + kAhead, all_entries - 1)].source);
    panel.number[entry[e].place] = front.a[entry[e].source];
  }
  constexpr int kColumns = 8;

  // Adds, some at a time, the columns of the children's matrices that are own columns here, or the
  // other ones.
  const auto add_children = [&](bool own, const auto& column_at) {
    for (int k = plan_.first_child[s]; k < plan_.first_child[s + 1]; ++k) {
      const int c = plan_.child[k];
      const UpdateMatrix update = GetUpdateMatrix(front, c);
      const RowRun* end = plan_.run.data() + plan_.first_run[c + 1];
      for (const RowRun* run = plan_.run.data() + plan_.first_run[c]; run != end; ++run) {
        const int first = own ? 0 : std::max(0, width - run->to);
        const int last = own ? std::min(run->length, width - run->to) : run->length;
        for (int n = first; n < last; n += kColumns) {
          const int count = std::min(last - n, kColumns);
          const double* from[kColumns];
          double* to[kColumns];
          for (int i = 0; i < count; ++i) {
            from[i] = update.column(run->from + n + i);
            to[i] = column_at(run->to + n + i);
          }
          kernels_->add_columns(from, to, run->from + n, count, run, end);
        }
      }
    }
  };
  add_children(true, [&](int j) { return panel.column(j); });
  if (!FactorPanel(panel, worker)) return false;
  // The numbers of L are written after the products, which hide that they come from memory.
  double* to = front.number + pattern_.first_number[s];
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(rows) * width;
  for (std::ptrdiff_t i = 0; i < std::min(size, kPrefetched); i += 8) __builtin_prefetch(to + i, 1);
  const UpdateMatrix update = GetUpdateMatrix(front, s);
  ForEachPart(worker, 0, update.size, static_cast<double>(update.size) * update.size * width,
              [&](int first, int last) { kernels_->multiply_below(panel, update, first, last); });
  for (int j = 0; j < width; ++j, to += rows)
    std::copy(panel.column(j) + j, panel.column(j) + rows, to + j);
  add_children(false, [&](int j) { return update.column(j - width) - width; });
  return true;
}

bool SupernodalFactor::Factor(const double* a, double* number, FactorWorkspace* workspace,
                              int threads, const std::atomic<bool>* cancel) const {
  const bool alone = threads <= 1;
  if (!alone) workspace->shared.Resize(shared_size_ + kMargin);
  workspace->panel.resize(threads);
  workspace->subtree.resize(threads);
  return tasks_.VisitUp(threads, [&](const TreeTasks::Worker& worker, const TreeTasks::Task& task) {
    const int thread = worker.thread;
    workspace->panel[thread].Resize(panel_size_);
    workspace->subtree[thread].Resize((alone ? alone_size_ : subtree_size_) + kMargin);
    const Front front{a, number, workspace->panel[thread].data(), workspace->subtree[thread].data(),
                      alone ? nullptr : workspace->shared.data()};
    for (int s = task.first; s <= task.last; ++s) {
      if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) return false;
      if (!FactorFront(front, s, worker)) return false;
    }
    return true;
  });
}

}  // namespace drape
