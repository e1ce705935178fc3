// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/backend.h"

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
  int threads() const override { return static_cast<int>(solvers_.size()); }

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
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights) override {
    CHECK_EQ(weights.size(), batch.size());
    return ForEach<RowMatrix>(batch.size(), [&](StepSolver& solver, int i) {
      RowMatrix dx;
      const bool ok =
          EquilibriumTangent(solver, *batch[i].material, *weights[i], batch[i].start->x, &dx);
      return ok ? dx : RowMatrix();
    });
  }

  std::vector<Eigen::VectorXd> EquilibriumJvp(
      std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) override {
    CHECK_EQ(changes.size(), batch.size());
    return ForEach<Eigen::VectorXd>(batch.size(), [&](StepSolver& solver, int i) {
      Eigen::VectorXd dx;
      const bool ok =
          EquilibriumJvpColumn(solver, *batch[i].material, *changes[i], batch[i].start->x, &dx);
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
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads())
    for (int i = 0; i < static_cast<int>(count); ++i)
      results[i] = work(solvers_[omp_get_thread_num()], i);
    return results;
  }

  std::shared_ptr<const ClothModel> model_;
  std::vector<StepSolver> solvers_;
};

LinearReadout ReadTangent(const Readout& readout, std::size_t i, const Eigen::VectorXd& x,
                          const RowMatrix& dx) {
  LinearReadout read;
  ReadoutJacobian dr_dx;
  if (!readout.Read(i, x, &read.r, &dr_dx)) return {};
  read.dr = dr_dx * dx;
  return read;
}

// The loss of rollout i at x, and ∂L/∂x, shape [3V, 1].
std::optional<double> SeedOfLoss(const ReadoutLoss& loss, std::size_t i, const Eigen::VectorXd& x,
                                 RowMatrix* seed) {
  Eigen::VectorXd r;
  ReadoutJacobian dr_dx;
  if (!loss.readout->Read(i, x, &r, &dr_dx)) return std::nullopt;
  const Eigen::VectorXd residual = (r - *loss.targets[i]) / loss.sigma;
  *seed = dr_dx.transpose() * (residual / loss.sigma);
  return 0.5 * residual.squaredNorm();
}

// The gradients of those results that have a loss, whose recordings and seeds are used up.
void AddGradients(Backend& backend, std::span<const RolloutInput> batch,
                  const RolloutOptions& options, std::vector<Recording>* recordings,
                  std::vector<RowMatrix>* seeds, std::vector<LossGradient>* results) {
  std::vector<LossGradient*> members;
  std::vector<RolloutInput> inputs;
  std::vector<Recording> kept;
  std::vector<RowMatrix> seeded;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (!(*results)[i].loss) continue;
    members.push_back(&(*results)[i]);
    inputs.push_back(batch[i]);
    kept.push_back(std::move((*recordings)[i]));
    seeded.push_back(std::move((*seeds)[i]));
  }
  std::vector<AdjointResult> adjoints = backend.Adjoints(inputs, kept, seeded, options);
  for (std::size_t k = 0; k < members.size(); ++k) {
    members[k]->status = adjoints[k].status;
    members[k]->material = std::move(adjoints[k].material);
    if (adjoints[k].status != RolloutStatus::kOk) *members[k] = {adjoints[k].status, {}, {}};
  }
}

}  // namespace

std::vector<ReadoutTangent> Backend::ReadoutTangents(std::span<const RolloutInput> batch,
                                                     std::span<const MaterialField* const> weights,
                                                     const RolloutOptions& options,
                                                     const Readout& readout) {
  std::vector<TangentResult> tangents = Tangents(batch, weights, options);
  std::vector<ReadoutTangent> results(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads())
  for (std::size_t i = 0; i < batch.size(); ++i) {
    results[i].rollout = std::move(tangents[i].rollout);
    if (results[i].rollout.status == RolloutStatus::kOk)
      results[i].read = ReadTangent(readout, i, results[i].rollout.end.x, tangents[i].dx);
  }
  return results;
}

std::vector<Eigen::VectorXd> Backend::EquilibriumJvp(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> changes) {
  std::vector<Eigen::VectorXd> directions;
  for (const RowMatrix& tangent : EquilibriumTangents(batch, changes))
    directions.push_back(tangent.rowwise().sum());
  return directions;
}

std::vector<LinearReadout> Backend::EquilibriumReadoutTangents(
    std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
    const Readout& readout) {
  const std::vector<RowMatrix> tangents = EquilibriumTangents(batch, weights);
  std::vector<LinearReadout> results(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads())
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (tangents[i].size() > 0)
      results[i] = ReadTangent(readout, i, batch[i].start->x, tangents[i]);
  return results;
}

void ReadoutLoss::Check(std::size_t count) const {
  CHECK(readout != nullptr);
  CHECK_GT(sigma, 0.0);
  CHECK_EQ(targets.size(), count);
  for (const Eigen::VectorXd* target : targets) CHECK_EQ(target->size(), readout->size());
}

std::vector<LossGradient> Backend::LossGradients(std::span<const RolloutInput> batch,
                                                 const RolloutOptions& options,
                                                 const ReadoutLoss& loss) {
  loss.Check(batch.size());
  std::vector<Recording> recordings;
  const std::vector<RolloutResult> ends = Rollouts(batch, options, &recordings);
  std::vector<LossGradient> results(batch.size());
  std::vector<RowMatrix> seeds(batch.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads())
  for (std::size_t i = 0; i < batch.size(); ++i) {
    results[i].status = ends[i].status;
    if (ends[i].status == RolloutStatus::kOk)
      results[i].loss = SeedOfLoss(loss, i, ends[i].end.x, &seeds[i]);
  }
  AddGradients(*this, batch, options, &recordings, &seeds, &results);
  return results;
}

std::unique_ptr<Backend> MakeCpuBackend(std::shared_ptr<const ClothModel> model, int threads) {
  return std::make_unique<CpuBackend>(std::move(model), threads);
}

}  // namespace drape
