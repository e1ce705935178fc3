// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glog/logging.h>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "physics/simulation/backend.h"

// The calls of the tasks of RunBatched, and who answers which together. Included by
// batching_backend.cc alone.
namespace drape::batching {

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

}  // namespace drape::batching
