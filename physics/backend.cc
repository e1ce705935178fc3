// SPDX-License-Identifier: Apache-2.0
#include "physics/backend.h"

#include <glog/logging.h>
#include <omp.h>

#include <utility>

namespace drape {
namespace {

class CpuBackend final : public Backend {
 public:
  CpuBackend(std::shared_ptr<const ClothModel> model, int threads) : model_(std::move(model)) {
    CHECK_GE(threads, 1);
    solvers_.emplace_back(model_);
    while (static_cast<int>(solvers_.size()) < threads)
      solvers_.push_back(solvers_.front().Clone());
  }

  std::string name() const override { return "cpu"; }
  const ClothModel& model() const override { return *model_; }

  std::vector<RolloutResult> Rollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options,
                                      std::vector<Recording>* recordings) override {
    if (recordings != nullptr) recordings->resize(batch.size());
    return ForEach<RolloutResult>(batch.size(), [&](StepSolver& solver, int i) {
      return Rollout(solver, *batch[i].material, *batch[i].start, options,
                     recordings == nullptr ? nullptr : &(*recordings)[i]);
    });
  }

  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions& options) override {
    CHECK_EQ(weights.size(), batch.size());
    return ForEach<TangentResult>(batch.size(), [&](StepSolver& solver, int i) {
      return RolloutTangent(solver, *batch[i].material, *weights[i], *batch[i].start, options);
    });
  }

  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording> recordings,
                                      std::span<const RowMatrix> seeds,
                                      const RolloutOptions& options) override {
    CHECK_EQ(recordings.size(), batch.size());
    CHECK_EQ(seeds.size(), batch.size());
    return ForEach<AdjointResult>(batch.size(), [&](StepSolver& solver, int i) {
      return RolloutAdjoint(solver, *batch[i].material, options, recordings[i], seeds[i]);
    });
  }

  std::vector<EquilibriumResult> Equilibria(std::span<const RolloutInput> batch,
                                            const EquilibriumOptions& options) override {
    return ForEach<EquilibriumResult>(batch.size(), [&](StepSolver& solver, int i) {
      return SolveEquilibrium(solver, *batch[i].material, batch[i].start->x, options);
    });
  }

  std::vector<RowMatrix> EquilibriumTangents(
      std::span<const RolloutInput> batch,
      std::span<const MaterialField* const> weights) override {
    CHECK_EQ(weights.size(), batch.size());
    return ForEach<RowMatrix>(batch.size(), [&](StepSolver& solver, int i) {
      RowMatrix dx;
      const bool ok =
          EquilibriumTangent(solver, *batch[i].material, *weights[i], batch[i].start->x, &dx);
      return ok ? dx : RowMatrix();
    });
  }

  std::vector<Eigen::VectorXd> EquilibriumDirections(
      std::span<const RolloutInput> batch,
      std::span<const MaterialField* const> changes) override {
    CHECK_EQ(changes.size(), batch.size());
    return ForEach<Eigen::VectorXd>(batch.size(), [&](StepSolver& solver, int i) {
      Eigen::VectorXd dx;
      const bool ok =
          EquilibriumDirection(solver, *batch[i].material, *changes[i], batch[i].start->x, &dx);
      return ok ? dx : Eigen::VectorXd();
    });
  }

  std::vector<std::optional<MaterialGradient>> EquilibriumAdjoints(
      std::span<const RolloutInput> batch, std::span<const RowMatrix> seeds) override {
    CHECK_EQ(seeds.size(), batch.size());
    using Gradient = std::optional<MaterialGradient>;
    return ForEach<Gradient>(batch.size(), [&](StepSolver& solver, int i) {
      MaterialGradient gradient;
      const bool ok =
          EquilibriumAdjoint(solver, *batch[i].material, batch[i].start->x, seeds[i], &gradient);
      return ok ? Gradient(std::move(gradient)) : std::nullopt;
    });
  }

 private:
  // Calls work(solver of this thread, item) for each item of a batch.
  template <class Result, class Work>
  std::vector<Result> ForEach(std::size_t count, const Work& work) {
    std::vector<Result> results(count);
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast<int>(solvers_.size()))
    for (int i = 0; i < static_cast<int>(count); ++i)
      results[i] = work(solvers_[omp_get_thread_num()], i);
    return results;
  }

  std::shared_ptr<const ClothModel> model_;
  std::vector<StepSolver> solvers_;
};

}  // namespace

std::vector<ReadoutTangent> Backend::ReadoutTangents(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
    const RolloutOptions& options, const ReadoutOf& readout) {
  std::vector<TangentResult> tangents = Tangents(batch, weights, options);
  std::vector<ReadoutTangent> results(batch.size());
  for (std::size_t i = 0; i < batch.size(); ++i) {
    results[i].rollout = std::move(tangents[i].rollout);
    if (results[i].rollout.status == RolloutStatus::kOk)
      results[i].dr = readout(i, results[i].rollout.end.x) * tangents[i].dx;
  }
  return results;
}

std::vector<Eigen::VectorXd> Backend::EquilibriumDirections(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) {
  std::vector<Eigen::VectorXd> directions;
  for (const RowMatrix& tangent : EquilibriumTangents(batch, changes))
    directions.push_back(tangent.rowwise().sum());
  return directions;
}

std::unique_ptr<Backend> MakeCpuBackend(std::shared_ptr<const ClothModel> model, int threads) {
  return std::make_unique<CpuBackend>(std::move(model), threads);
}

}  // namespace drape
