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
namespace batching {

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
  const Backend* inner = nullptr;
  CallKind kind = CallKind::kUnbatched;
  RolloutOptions rollout;
  EquilibriumOptions equilibrium;
  bool operator==(const CallKey&) const = default;
};

// The inputs of one call or of several together.
struct Inputs {
  std::vector<RolloutInput> batch;
  std::vector<const MaterialField*> weights;  // as many, or empty where the kind takes none
};

// What a task waits for.
struct Call {
  // Answers this call and all others of `joined`, whose first this is.
  std::function<void(std::span<Call* const> joined)> answer;
  CallKey key = {};
  Inputs inputs = {};
  std::size_t size = 0;  // of the batch
  void* results =
      nullptr;  // of joinable calls: std::vector<Result>*, where Result follows the kind
  bool serial = false;
  bool answered = false;
  std::exception_ptr error = {};
};

// Runs the inputs of all calls as one batch and divides the results among them.
template <class Result>
void AnswerTogether(std::span<Call* const> joined,
                    const std::function<std::vector<Result>(const Inputs&)>& run) {
  Inputs all;
  for (const Call* call : joined) {
    all.batch.insert(all.batch.end(), call->inputs.batch.begin(), call->inputs.batch.end());
    all.weights.insert(all.weights.end(), call->inputs.weights.begin(), call->inputs.weights.end());
  }
  std::vector<Result> results = run(all);
  CHECK_EQ(results.size(), all.batch.size());
  auto next = std::make_move_iterator(results.begin());
  for (Call* call : joined) {
    static_cast<std::vector<Result>*>(call->results)->assign(next, next + call->size);
    next += call->size;
  }
}

// Synchronises the threads of the tasks with the one that answers their calls.
class BatchScheduler {
 public:
  explicit BatchScheduler(int threads) : running_(threads) {}
  // One for threads that register, until it is closed. It answers when half of them wait, so that
  // some compute meanwhile.
  static BatchScheduler Open() { return BatchScheduler(0, true); }

  // Returns when the call of a task is answered, or throws its error.
  void Wait(int task, Call& call) {
    std::unique_lock lock(mutex_);
    waiting_.emplace(task, &call);
    NotifyWhenReady();
    answered_.wait(lock, [&] { return call.answered; });
    if (call.error) std::rethrow_exception(call.error);
  }

  void ReportError(int task, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    errors_.emplace(task, std::move(error));
  }
  // Returns the number of the thread, from 0.
  int Register() {
    const std::lock_guard lock(mutex_);
    ++running_;
    return registered_++;
  }
  void Deregister(int threads) {
    const std::lock_guard lock(mutex_);
    running_ -= threads;
    NotifyWhenReady();
  }
  void Close() {
    const std::lock_guard lock(mutex_);
    is_open_ = false;
    NotifyWhenReady();
  }

  // Answers calls until all threads are deregistered and no further one may come.
  void ServeUntilDone() {
    std::unique_lock lock(mutex_);
    for (;;) {
      ready_.wait(lock, [&] { return IsReady(); });
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
  BatchScheduler(int threads, bool is_open) : running_(threads), is_open_(is_open) {}

  bool IsReady() const {
    const auto waiting = static_cast<int>(waiting_.size());
    if (is_open_) return running_ > 0 && 2 * waiting >= running_;
    return waiting == running_;
  }
  void NotifyWhenReady() {
    if (IsReady()) ready_.notify_one();
  }

  static std::exception_ptr Answer(const std::vector<Call*>& joined) {
    try {
      joined.front()->answer(joined);
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }

  // The waiting calls that are answered together with `first`, which is among them.
  std::vector<Call*> FindJoinable(Call* first) const {
    if (first->key.kind == CallKind::kUnbatched) return {first};
    std::vector<Call*> group;
    for (const auto& [task, call] : waiting_)
      if (call->key == first->key) group.push_back(call);
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
      for (const Call* member : group) size += member->size;
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
  std::condition_variable ready_, answered_;
  std::map<int, Call*> waiting_;              // by task
  std::map<int, std::exception_ptr> errors_;  // that left a task
  int running_;                               // threads
  bool is_open_ = false;
  int registered_ = 0;
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
    Call call{.answer = [&](std::span<Call* const>) { act(); }, .serial = true};
    scheduler_->Wait(index_, call);
  }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options,
                                      std::vector<Recording>* recordings) override {
    if (recordings != nullptr)
      return CallUnbatched(batch.size(),
                           [&] { return inner_->Rollouts(batch, options, recordings); });
    return Join<RolloutResult>(
        {inner_, CallKind::kRollouts, options, {}}, batch, {},
        [&](const Inputs& all) { return inner_->Rollouts(all.batch, options, nullptr); });
  }

  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions& options) override {
    CHECK_EQ(weights.size(), batch.size());
    return Join<TangentResult>(
        {inner_, CallKind::kTangents, options, {}}, batch, weights,
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
        {inner_, CallKind::kEquilibria, {}, options}, batch, {},
        [&](const Inputs& all) { return inner_->Equilibria(all.batch, options); });
  }

  std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) override {
    CHECK_EQ(weights.size(), batch.size());
    return Join<RowMatrix>(
        {inner_, CallKind::kEquilibriumTangents, {}, {}}, batch, weights,
        [&](const Inputs& all) { return inner_->EquilibriumTangents(all.batch, all.weights); });
  }

  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    CHECK_EQ(changes.size(), batch.size());
    return Join<Eigen::VectorXd>(
        {inner_, CallKind::kEquilibriumJvp, {}, {}}, batch, changes,
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
                           const std::function<std::vector<Result>(const Inputs&)>& run) {
    std::vector<Result> results;
    Call call{.answer = [&](std::span<Call* const> joined) { AnswerTogether(joined, run); },
              .key = key,
              .inputs = {{batch.begin(), batch.end()}, {weights.begin(), weights.end()}},
              .size = batch.size(),
              .results = &results};
    scheduler_->Wait(index_, call);
    return results;
  }

  template <class Act>
  std::invoke_result_t<Act> CallUnbatched(std::size_t size, const Act& act) {
    std::invoke_result_t<Act> results;
    Call call{.answer = [&](std::span<Call* const>) { results = act(); }, .size = size};
    scheduler_->Wait(index_, call);
    return results;
  }

  Backend* inner_;
  BatchScheduler* scheduler_;
  int index_;
};

}  // namespace batching

void RunBatched(Backend& inner, int count, int max_threads,
                const std::function<void(BatchingBackend&)>& work) {
  CHECK_GE(max_threads, 1);
  const int wanted = std::min(count, max_threads);
  batching::BatchScheduler scheduler(wanted);
  std::atomic<int> next = 0;
  const auto run_tasks = [&] {
    for (int i = next++; i < count && !scheduler.failed(); i = next++) {
      batching::Task task(&inner, &scheduler, i);
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

struct SharedBackends::State {
  batching::BatchScheduler scheduler = batching::BatchScheduler::Open();
  std::mutex mutex;
  std::map<std::string, std::unique_ptr<Backend>> backends;  // by key
  std::jthread server{[this] { scheduler.ServeUntilDone(); }};
};

SharedBackends::SharedBackends() : state_(std::make_unique<State>()) {}
SharedBackends::~SharedBackends() { state_->scheduler.Close(); }

SharedBackends::Member::Member(SharedBackends& all)
    : all_(all), index_(all.state_->scheduler.Register()) {}
SharedBackends::Member::~Member() { all_.state_->scheduler.Deregister(1); }

std::unique_ptr<Backend> SharedBackends::Member::Share(
    const std::string& key, const std::function<std::unique_ptr<Backend>()>& make) {
  const std::lock_guard lock(all_.state_->mutex);
  std::unique_ptr<Backend>& inner = all_.state_->backends[key];
  if (inner == nullptr) inner = make();
  return std::make_unique<batching::Task>(inner.get(), &all_.state_->scheduler, index_);
}

}  // namespace drape
