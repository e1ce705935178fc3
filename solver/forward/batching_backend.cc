// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/batching_backend.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <span>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

namespace drape {
namespace {

enum class CallKind {
  kUnbatched,
  kRollouts,
  kTangents,
  kEquilibria,
  kEquilibriumTangents,
  kEquilibriumJvp
};

// Calls of equal keys can be joined, except those of kUnbatched.
struct CallKey {
  CallKind kind = CallKind::kUnbatched;
  RolloutOptions rollout;
  EquilibriumOptions equilibrium;
  bool operator==(const CallKey&) const = default;
};

// What a task waits for.
class Call {
 public:
  explicit Call(const CallKey& key) : key_(key) {}
  virtual ~Call() = default;
  const CallKey& key() const { return key_; }
  virtual std::size_t size() const = 0;
  // Answers this and all others of `joined`, whose first this is.
  virtual void Answer(std::span<Call* const> joined) = 0;

  bool serial = false;
  bool answered = false;
  std::exception_ptr error;

 private:
  CallKey key_;
};

class UnbatchedCall final : public Call {
 public:
  UnbatchedCall(std::size_t size, const std::function<void()>& act)
      : Call(CallKey()), size_(size), act_(act) {}
  std::size_t size() const override { return size_; }
  void Answer(std::span<Call* const>) override { act_(); }

 private:
  std::size_t size_;
  const std::function<void()>& act_;
};

// The inputs of one call or of several together.
struct Inputs {
  std::vector<RolloutInput> batch;
  std::vector<const MaterialField*> weights;  // as many, or empty where the kind takes none
};

template <class Result>
class JoinedCall final : public Call {
 public:
  // Runs a batch for some calls of this key.
  using Run = std::function<std::vector<Result>(const Inputs& inputs)>;
  JoinedCall(const CallKey& key, Inputs inputs, const Run& run)
      : Call(key), inputs_(std::move(inputs)), run_(run) {}

  std::size_t size() const override { return inputs_.batch.size(); }
  std::vector<Result> TakeResults() { return std::move(results_); }

  void Answer(std::span<Call* const> joined) override {
    Inputs all;
    for (Call* call : joined) {
      const Inputs& inputs = static_cast<JoinedCall*>(call)->inputs_;
      all.batch.insert(all.batch.end(), inputs.batch.begin(), inputs.batch.end());
      all.weights.insert(all.weights.end(), inputs.weights.begin(), inputs.weights.end());
    }
    std::vector<Result> results = run_(all);
    CHECK_EQ(results.size(), all.batch.size());
    auto next = std::make_move_iterator(results.begin());
    for (Call* call : joined) {
      static_cast<JoinedCall*>(call)->results_.assign(next, next + call->size());
      next += call->size();
    }
  }

 private:
  Inputs inputs_;
  const Run& run_;
  std::vector<Result> results_;
};

// Synchronises the threads of the tasks with the one that answers their calls.
class BatchScheduler {
 public:
  explicit BatchScheduler(int threads) : running_(threads) {}

  // Returns when the call of a task is answered, or throws its error.
  void Wait(int task, Call& call) {
    std::unique_lock lock(mutex_);
    waiting_.emplace(task, &call);
    NotifyWhenAllWait();
    answered_.wait(lock, [&] { return call.answered; });
    if (call.error) std::rethrow_exception(call.error);
  }

  void ReportError(int task, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    errors_.emplace(task, std::move(error));
  }
  void Deregister(int threads) {
    const std::lock_guard lock(mutex_);
    running_ -= threads;
    NotifyWhenAllWait();
  }

  // Answers calls until all threads are deregistered.
  void ServeUntilDone() {
    std::unique_lock lock(mutex_);
    for (;;) {
      all_wait_.wait(lock, [&] { return AllWait(); });
      if (running_ == 0) return;
      const std::vector<Call*> joined = TakeNext();
      const std::exception_ptr failure = errors_.empty() ? nullptr : errors_.begin()->second;
      lock.unlock();
      const std::exception_ptr error = failure ? failure : Answer(joined);
      lock.lock();
      for (Call* call : joined) {
        call->error = error;
        call->answered = true;
      }
      answered_.notify_all();
    }
  }

  bool failed() {
    const std::lock_guard lock(mutex_);
    return !errors_.empty();
  }
  void RethrowFirst() const {
    if (!errors_.empty()) std::rethrow_exception(errors_.begin()->second);
  }

 private:
  bool AllWait() const { return static_cast<int>(waiting_.size()) == running_; }
  void NotifyWhenAllWait() {
    if (AllWait()) all_wait_.notify_one();
  }

  static std::exception_ptr Answer(const std::vector<Call*>& joined) {
    try {
      joined.front()->Answer(joined);
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }

  // The waiting calls that are answered together with `first`, which is among them.
  std::vector<Call*> FindJoinable(Call* first) const {
    if (first->key().kind == CallKind::kUnbatched) return {first};
    std::vector<Call*> group;
    for (const auto& [task, call] : waiting_)
      if (call->key() == first->key()) group.push_back(call);
    return group;
  }

  std::vector<Call*> TakeNext() {
    std::vector<Call*> best;
    std::size_t most = 0;
    for (const auto& [task, call] : waiting_) {
      if (call->serial) {
        best = {call};
        break;
      }
      std::vector<Call*> group = FindJoinable(call);
      std::size_t size = 0;
      for (const Call* member : group) size += member->size();
      if (!best.empty() && size <= most) continue;
      best = std::move(group);
      most = size;
    }
    std::erase_if(waiting_, [&](const auto& entry) {
      return std::find(best.begin(), best.end(), entry.second) != best.end();
    });
    return best;
  }

  std::mutex mutex_;
  std::condition_variable all_wait_, answered_;
  std::map<int, Call*> waiting_;              // by task
  std::map<int, std::exception_ptr> errors_;  // that left a task
  int running_;                               // threads
};

class Task final : public BatchingBackend {
 public:
  Task(Backend* inner, BatchScheduler* scheduler, int index)
      : inner_(inner), scheduler_(scheduler), index_(index) {}

  int index() const override { return index_; }
  std::string name() const override { return inner_->name(); }
  const ClothModel& model() const override { return inner_->model(); }
  int threads() const override { return inner_->threads(); }

  void RunSerially(const std::function<void()>& act) override {
    UnbatchedCall call(0, act);
    call.serial = true;
    scheduler_->Wait(index_, call);
  }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options,
                                      std::vector<Recording>* recordings) override {
    if (recordings != nullptr)
      return CallUnbatched(batch.size(),
                           [&] { return inner_->Rollouts(batch, options, recordings); });
    return Join<RolloutResult>(
        {CallKind::kRollouts, options, {}}, batch, {},
        [&](const Inputs& all) { return inner_->Rollouts(all.batch, options, nullptr); });
  }

  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions& options) override {
    CHECK_EQ(weights.size(), batch.size());
    return Join<TangentResult>(
        {CallKind::kTangents, options, {}}, batch, weights,
        [&](const Inputs& all) { return inner_->Tangents(all.batch, all.weights, options); });
  }

  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording> recordings,
                                      std::span<const RowMatrix> dL_dx,
                                      const RolloutOptions& options) override {
    return CallUnbatched(batch.size(),
                         [&] { return inner_->Adjoints(batch, recordings, dL_dx, options); });
  }

  std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                            const EquilibriumOptions& options) override {
    return Join<EquilibriumResult>(
        {CallKind::kEquilibria, {}, options}, batch, {},
        [&](const Inputs& all) { return inner_->Equilibria(all.batch, options); });
  }

  std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) override {
    CHECK_EQ(weights.size(), batch.size());
    return Join<RowMatrix>(
        {CallKind::kEquilibriumTangents, {}, {}}, batch, weights,
        [&](const Inputs& all) { return inner_->EquilibriumTangents(all.batch, all.weights); });
  }

  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    CHECK_EQ(changes.size(), batch.size());
    return Join<Eigen::VectorXd>(
        {CallKind::kEquilibriumJvp, {}, {}}, batch, changes,
        [&](const Inputs& all) { return inner_->EquilibriumJvp(all.batch, all.weights); });
  }

  std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix> dL_dx) override {
    return CallUnbatched(batch.size(), [&] { return inner_->EquilibriumAdjoints(batch, dL_dx); });
  }

 private:
  template <class Result>
  std::vector<Result> Join(const CallKey& key, std::span<const RolloutInput> batch,
                           std::span<const MaterialField* const> weights,
                           const typename JoinedCall<Result>::Run& run) {
    JoinedCall<Result> call(key, {{batch.begin(), batch.end()}, {weights.begin(), weights.end()}},
                            run);
    scheduler_->Wait(index_, call);
    return call.TakeResults();
  }

  template <class Act>
  std::invoke_result_t<Act> CallUnbatched(std::size_t size, const Act& act) {
    std::invoke_result_t<Act> results;
    const std::function<void()> answer = [&] { results = act(); };
    UnbatchedCall call(size, answer);
    scheduler_->Wait(index_, call);
    return results;
  }

  Backend* inner_;
  BatchScheduler* scheduler_;
  int index_;
};

}  // namespace

void RunBatched(Backend& inner, int count, int max_threads,
                const std::function<void(BatchingBackend&)>& work) {
  CHECK_GE(max_threads, 1);
  const int wanted = std::min(count, max_threads);
  BatchScheduler scheduler(wanted);
  std::atomic<int> next = 0;
  const auto run_tasks = [&] {
    for (int i = next++; i < count && !scheduler.failed(); i = next++) {
      Task task(&inner, &scheduler, i);
      try {
        work(task);
      } catch (...) {
        scheduler.ReportError(i, std::current_exception());
      }
    }
    scheduler.Deregister(1);
  };
  std::vector<std::jthread> threads;
  try {
    while (static_cast<int>(threads.size()) < wanted) threads.emplace_back(run_tasks);
  } catch (const std::system_error&) {  // the system's limit: fewer threads suffice
    if (threads.empty()) throw;
    scheduler.Deregister(wanted - static_cast<int>(threads.size()));
  }
  scheduler.ServeUntilDone();
  threads.clear();
  scheduler.RethrowFirst();
}

}  // namespace drape
