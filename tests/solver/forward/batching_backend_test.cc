// SPDX-License-Identifier: Apache-2.0
// Joined calls of several tasks, on a backend whose answers are known sums.
#include "solver/forward/batching_backend.h"

#include <gmock/gmock.h>

#include <chrono>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/physics/cloth_fixture.h"
#include "tests/physics/summed_tangents.h"

namespace drape {
namespace {

using testing::AnyOf;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

// Answers x + density [+ h] of each input and keeps the sizes of its batches, by kind.
class SumBackend final : public Backend {
 public:
  std::string name() const override { return "sum"; }
  const ClothModel& model() const override { return *model_; }
  std::shared_ptr<const ClothModel> shared_model() const { return model_; }
  int threads() const override { return 1; }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options,
                                      std::vector<Recording>* recordings) override {
    Keep(recordings == nullptr ? 'r' : 'R', batch.size());
    if (recordings != nullptr) recordings->resize(batch.size());
    std::vector<RolloutResult> results;
    for (const RolloutInput& input : batch)
      results.push_back({RolloutStatus::kOk, {Sum(input).array() + options.h, {}}, options.steps});
    return results;
  }
  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions&) override {
    Keep('t', batch.size());
    std::vector<TangentResult> results;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      results.emplace_back().rollout.end.x = Sum(batch[i]);
      results.back().dx = RowMatrix::Constant(1, 1, weights[i]->density);
    }
    return results;
  }
  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording>, std::span<const RowMatrix>,
                                      const RolloutOptions&) override {
    Keep('a', batch.size());
    return std::vector<AdjointResult>(batch.size());
  }
  std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                            const EquilibriumOptions&) override {
    Keep('e', batch.size());
    if (throws) throw std::runtime_error("out of memory");
    std::vector<EquilibriumResult> results(batch.size());
    for (std::size_t i = 0; i < batch.size(); ++i) results[i].x = Sum(batch[i]);
    return results;
  }
  std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) override {
    Keep('d', batch.size());
    std::vector<RowMatrix> results;
    for (std::size_t i = 0; i < batch.size(); ++i)
      results.push_back(RowMatrix::Constant(1, 1, weights[i]->density + batch[i].start->x[0]));
    return results;
  }
  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    Keep('j', batch.size());
    std::vector<Eigen::VectorXd> results;
    for (std::size_t i = 0; i < batch.size(); ++i)
      results.push_back(Eigen::VectorXd::Constant(1, changes[i]->density + batch[i].start->x[0]));
    return results;
  }
  std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix>) override {
    Keep('g', batch.size());
    return std::vector<std::optional<MaterialGradient>>(batch.size());
  }

  // "r16": a batch of 16 rollouts.
  std::vector<std::string> batches;
  std::set<std::thread::id> callers;
  bool throws = false;

 private:
  void Keep(char kind, std::size_t size) {
    batches.push_back(kind + std::to_string(size));
    callers.insert(std::this_thread::get_id());
  }
  static Eigen::VectorXd Sum(const RolloutInput& input) {
    return input.start->x.array() + input.material->density;
  }
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 120);
};

// A task's own inputs: `count` states and materials in which its number stands.
struct OwnInputs {
  OwnInputs(int task, int count) : materials(count, test::TestMaterial()), starts(count) {
    for (int i = 0; i < count; ++i) {
      materials[i].density = 1000.0 * task;
      starts[i].x = Eigen::VectorXd::Constant(1, i);
      batch.push_back({&materials[i], &starts[i]});
      weights.push_back(&materials[i]);
    }
  }
  std::vector<MaterialField> materials;
  std::vector<State> starts;
  std::vector<RolloutInput> batch;
  std::vector<const MaterialField*> weights;
};

class BatchingBackendTest : public testing::Test {
 protected:
  // Calls of one kind with a check of the answers.
  static void Roll(Backend& backend, int task, int count, const RolloutOptions& options = {}) {
    const OwnInputs own(task, count);
    const auto results = backend.Rollouts(own.batch, options, nullptr);
    ASSERT_EQ(results.size(), count);
    for (int i = 0; i < count; ++i)
      EXPECT_EQ(results[i].end.x[0], 1000.0 * task + i + options.h) << task;
  }
  static void Rest(Backend& backend, int task, int count) {
    const OwnInputs own(task, count);
    const auto results = backend.Equilibria(own.batch, {});
    ASSERT_EQ(results.size(), count);
    for (int i = 0; i < count; ++i) EXPECT_EQ(results[i].x[0], 1000.0 * task + i) << task;
  }
  static void Differentiate(Backend& backend, int task, int count) {
    const OwnInputs own(task, count);
    const auto results = backend.EquilibriumTangents(own.batch, own.weights);
    ASSERT_EQ(results.size(), count);
    for (int i = 0; i < count; ++i) EXPECT_EQ(results[i](0, 0), 1000.0 * task + i) << task;
  }
  static void Jvp(Backend& backend, int task, int count) {
    const OwnInputs own(task, count);
    const auto results = backend.EquilibriumJvp(own.batch, own.weights);
    ASSERT_EQ(results.size(), count);
    for (int i = 0; i < count; ++i) EXPECT_EQ(results[i][0], 1000.0 * task + i) << task;
  }
  static void Tangent(Backend& backend, int task, int count) {
    const OwnInputs own(task, count);
    const auto results = backend.Tangents(own.batch, own.weights, {});
    ASSERT_EQ(results.size(), count);
    for (int i = 0; i < count; ++i) EXPECT_EQ(results[i].dx(0, 0), 1000.0 * task) << task;
  }
  void Gather(int count, const std::function<void(BatchingBackend&)>& work, int max_threads = 64) {
    RunBatched(inner_, count, max_threads, work);
  }
  SumBackend inner_;
};

TEST_F(BatchingBackendTest, CallsOfOneKindAreOneBatch) {
  Gather(8, [](BatchingBackend& task) {
    Roll(task, task.index(), 2);
    Tangent(task, task.index(), 1 + task.index() % 2);
    Rest(task, task.index(), 3);
    Differentiate(task, task.index(), task.index() == 5 ? 0 : 1);
    Jvp(task, task.index(), 2);
  });
  EXPECT_THAT(inner_.batches, ElementsAre("r16", "t12", "e24", "d7", "j16"));
  EXPECT_THAT(inner_.callers, ElementsAre(std::this_thread::get_id()));
}

// Two or three of three threads that come and go make a batch, and the last goes on alone.
TEST_F(BatchingBackendTest, ThreadsShareABackend) {
  std::vector<std::string>* batches = nullptr;
  {
    SharedBackends shared;
    std::vector<std::unique_ptr<SharedBackends::Member>> members;
    for (int i = 0; i < 3; ++i) members.push_back(std::make_unique<SharedBackends::Member>(shared));
    const auto make = [&] {
      auto inner = std::make_unique<SumBackend>();
      EXPECT_EQ(std::exchange(batches, &inner->batches), nullptr) << "one for each key";
      return inner;
    };
    std::vector<std::jthread> threads;
    for (int i = 0; i < 3; ++i)
      threads.emplace_back([&, i] {
        const auto backend = members[i]->Share("disc", make);
        Roll(*backend, i, 2);
        if (i == 2) Rest(*backend, i, 1);
        members[i].reset();
      });
    threads.clear();
    EXPECT_THAT(*batches,
                AnyOf(UnorderedElementsAre("r6", "e1"), UnorderedElementsAre("r4", "r2", "e1")));
  }
}

// Of a real backend: the bits of a joined call are those of a call of its own.
TEST_F(BatchingBackendTest, JoinedJvpsOfACpuBackendAreItsOwn) {
  const auto cpu = MakeCpuBackend(inner_.shared_model(), 2);
  const MaterialField material = test::TestMaterial();
  State rest = cpu->model().RestState();
  std::mt19937_64 random(5);
  rest = cpu->Rollouts(std::vector<RolloutInput>{{&material, &rest}}, {.h = 0.1, .steps = 60},
                       nullptr)[0]
             .end;
  const RolloutInput input{&material, &rest};
  rest.x = cpu->Equilibria({&input, 1}, {})[0].x;
  std::vector<MaterialField> changes;
  for (int i = 0; i < 4; ++i)
    changes.push_back(test::Scatter(material, cpu->model().mesh, 0.5, random));
  std::vector<Eigen::VectorXd> found(changes.size());
  RunBatched(*cpu, static_cast<int>(changes.size()), 64, [&](BatchingBackend& task) {
    const MaterialField* change = &changes[task.index()];
    found[task.index()] = task.EquilibriumJvp({&input, 1}, {&change, 1})[0];
  });
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const MaterialField* change = &changes[i];
    ASSERT_GT(found[i].size(), 0) << i;
    EXPECT_EQ(found[i], cpu->EquilibriumJvp({&input, 1}, {&change, 1})[0]) << i;
    const auto summed = test::SumEquilibriumTangents(*cpu, {&input, 1}, {&change, 1});
    EXPECT_LT((found[i] - summed[0]).norm(), 1e-10 * summed[0].norm()) << i;
  }
}

TEST_F(BatchingBackendTest, OtherOptionsAreAnotherBatch) {
  const std::atomic<bool> cancel = false;
  Gather(7, [&](BatchingBackend& task) {
    RolloutOptions options;
    if (task.index() >= 4) options.h = 0.25;
    if (task.index() == 6) options.cancel = &cancel;
    Roll(task, task.index(), 1, options);
  });
  EXPECT_THAT(inner_.batches, ElementsAre("r4", "r2", "r1"));
}

TEST_F(BatchingBackendTest, TheLargestGroupIsAnsweredFirst) {
  Gather(5, [](BatchingBackend& task) {
    if (task.index() >= 2) Rest(task, task.index(), 1);
    Differentiate(task, task.index(), 1);
  });
  EXPECT_THAT(inner_.batches, ElementsAre("e3", "d5"));
}

TEST_F(BatchingBackendTest, TasksThatEndAreNotWaitedFor) {
  Gather(4, [](BatchingBackend& task) {
    for (int i = 0; i < task.index(); ++i) Rest(task, task.index(), 1);
  });
  EXPECT_THAT(inner_.batches, ElementsAre("e3", "e2", "e1"));
}

TEST_F(BatchingBackendTest, NoMoreThanTheLimitRunAtATime) {
  Gather(
      7, [](BatchingBackend& task) { Rest(task, task.index(), 1); }, 3);
  EXPECT_THAT(inner_.batches, ElementsAre("e3", "e3", "e1"));
  inner_.batches.clear();
  Gather(
      2, [](BatchingBackend& task) { Rest(task, task.index(), 1); }, 1);
  EXPECT_THAT(inner_.batches, ElementsAre("e1", "e1"));
  Gather(0, [](BatchingBackend&) { FAIL(); });
}

TEST_F(BatchingBackendTest, RecordingsAndAdjointsAreNotJoined) {
  std::vector<std::vector<Recording>> recordings(2);
  Gather(2, [&](BatchingBackend& task) {
    const OwnInputs own(task.index(), 3);
    std::vector<Recording>& recording = recordings[task.index()];
    const auto results = task.Rollouts(own.batch, {}, &recording);
    EXPECT_EQ(results[2].end.x[0], 1000.0 * task.index() + 2 + RolloutOptions().h);
    EXPECT_EQ(recording.size(), 3);
    const std::vector<RowMatrix> seeds(3);
    EXPECT_EQ(task.Adjoints(own.batch, recording, seeds, {}).size(), 3);
    EXPECT_EQ(task.EquilibriumAdjoints(own.batch, seeds).size(), 3);
  });
  EXPECT_THAT(inner_.batches, testing::UnorderedElementsAre("R3", "R3", "a3", "a3", "g3", "g3"));
}

TEST_F(BatchingBackendTest, AnErrorReachesAllOfItsBatchAndNoOther) {
  inner_.throws = true;
  std::vector<int> caught(6);
  Gather(6, [&](BatchingBackend& task) {
    if (task.index() == 5) return Differentiate(task, 5, 1);
    EXPECT_THROW(Rest(task, task.index(), 1), std::runtime_error);
    ++caught[task.index()];
    Differentiate(task, task.index(), 1);
  });
  EXPECT_THAT(caught, ElementsAre(1, 1, 1, 1, 1, 0));
  EXPECT_THAT(inner_.batches, ElementsAre("e5", "d6"));
}

TEST_F(BatchingBackendTest, AnErrorThatLeavesATaskEndsAll) {
  int rounds = 0;
  EXPECT_THROW(Gather(
                   64,
                   [&](BatchingBackend& task) {
                     for (int i = 0;; ++i) {
                       if (task.index() == 3 && i == 2) throw std::out_of_range("full disk");
                       Rest(task, task.index(), 1);
                       if (task.index() == 0) ++rounds;
                     }
                   },
                   8),
               std::out_of_range);
  EXPECT_EQ(rounds, 2);
  EXPECT_THAT(inner_.batches, ElementsAre("e8", "e8"));
}

TEST_F(BatchingBackendTest, RunSeriallyRunsByTaskOnTheCallersThread) {
  std::vector<int> order;  // without a lock: all in one thread
  const auto caller = std::this_thread::get_id();
  Gather(6, [&](BatchingBackend& task) {
    for (int round = 0; round < 3; ++round) {
      if (task.index() % 2 == 1) Rest(task, task.index(), 1);
      task.RunSerially([&] {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        order.push_back(10 * round + task.index());
      });
    }
  });
  EXPECT_THAT(order, ElementsAre(0, 10, 20, 2, 12, 22, 4, 14, 24, 1, 3, 5, 11, 13, 15, 21, 23, 25));
}

TEST_F(BatchingBackendTest, AnErrorInRunSeriallyReachesItsTask) {
  EXPECT_THROW(
      Gather(3,
             [](BatchingBackend& task) { task.RunSerially([] { throw std::logic_error("x"); }); }),
      std::logic_error);
}

// Some calls of each kind, in an order that the task's number decides, with pauses that it does
// not.
void ManyRounds(BatchingBackend& task) {
  std::mt19937 plan(task.index()), pauses(std::random_device{}());
  const int rounds = 20 + plan() % 40;
  for (int round = 0; round < rounds; ++round) {
    if (pauses() % 8 == 0) std::this_thread::sleep_for(std::chrono::microseconds(pauses() % 50));
    const OwnInputs own(task.index(), 1 + plan() % 3);
    RolloutOptions options;
    options.steps = plan() % 2;
    switch (plan() % 3) {
      case 0:
        EXPECT_EQ(task.Rollouts(own.batch, options, nullptr).size(), own.batch.size());
        break;
      case 1:
        EXPECT_EQ(task.Equilibria(own.batch, {}).size(), own.batch.size());
        break;
      default:
        task.RunSerially([] {});
    }
  }
}

TEST_F(BatchingBackendTest, BatchesDoNotDependOnTheTimingOfThreads) {
  Gather(40, ManyRounds, 16);
  const std::vector<std::string> once = inner_.batches;
  EXPECT_GT(once.size(), 100);
  for (int again = 0; again < 3; ++again) {
    inner_.batches.clear();
    Gather(40, ManyRounds, 16);
    EXPECT_EQ(inner_.batches, once);
  }
}

}  // namespace
}  // namespace drape
