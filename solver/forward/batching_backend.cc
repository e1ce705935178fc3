// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/batching_backend.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <type_traits>

#include "solver/forward/batch_scheduler.h"

namespace drape {
namespace {

using namespace batching;

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
