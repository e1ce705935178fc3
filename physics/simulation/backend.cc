// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/backend.h"

#include <glog/logging.h>
#include <omp.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <utility>

#include "physics/material/material_scaling.h"

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
    RolloutOptions of_each = options;
    of_each.factor_memory /= std::max<std::size_t>(1, batch.size());
    if (recordings != nullptr) recordings->resize(batch.size());
    return ForEach<RolloutResult>(batch.size(), [&](StepSolver& solver, int i) {
      return Rollout(solver, *batch[i].material, *batch[i].start, of_each,
                     recordings == nullptr ? nullptr : &(*recordings)[i]);
    });
  }

  std::vector<TangentResult> Tangents(std::span<const RolloutInput> batch,
                                      std::span<const MaterialField* const> weights,
                                      const RolloutOptions& options) override {
    CHECK_EQ(weights.size(), batch.size());
    return ForEach<TangentResult>(batch.size(), [&](StepSolver& solver, int i) {
      const TangentOptions* more = batch[i].tangent;
      return RolloutTangent(solver, *batch[i].material, *weights[i], *batch[i].start, options,
                            more == nullptr ? TangentOptions() : *more);
    });
  }

  std::vector<AdjointResult> Adjoints(std::span<const RolloutInput> batch,
                                      std::span<const Recording> recordings,
                                      std::span<const RowMatrix> dL_dx,
                                      const RolloutOptions& options) override {
    CHECK_EQ(recordings.size(), batch.size());
    CHECK_EQ(dL_dx.size(), batch.size());
    return ForEach<AdjointResult>(batch.size(), [&](StepSolver& solver, int i) {
      const AdjointOptions* more = batch[i].adjoint;
      return RolloutAdjoint(solver, *batch[i].material, options, recordings[i], dL_dx[i],
                            more == nullptr ? AdjointOptions() : *more);
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
          EquilibriumTangent(solver, *batch[i].material, *weights[i], batch[i].start->x, &dx,
                             batch[i].tangent != nullptr && batch[i].tangent->dynamics);
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
      std::span<const RolloutInput> batch, std::span<const RowMatrix> dL_dx) override {
    CHECK_EQ(dL_dx.size(), batch.size());
    using Gradient = std::optional<MaterialGradient>;
    return ForEach<Gradient>(batch.size(), [&](StepSolver& solver, int i) {
      MaterialGradient gradient;
      const bool ok =
          EquilibriumAdjoint(solver, *batch[i].material, batch[i].start->x, dL_dx[i], &gradient);
      return ok ? Gradient(std::move(gradient)) : std::nullopt;
    });
  }

 private:
  // Calls work(solver of this thread, item) for each item of a batch. An item that is alone has all
  // threads for its factorisations, on which its result does not depend.
  template <class Result, class Work>
  std::vector<Result> ForEach(std::size_t count, const Work& work) {
    std::vector<Result> results(count);
    for (StepSolver& solver : solvers_) solver.SetThreads(count == 1 ? threads() : 1);
    std::exception_ptr error;  // out of memory; an exception may not leave a parallel region
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads()) if (count > 1)
    for (int i = 0; i < static_cast<int>(count); ++i) {
      try {
        results[i] = work(solvers_[omp_get_thread_num()], i);
      } catch (...) {
#pragma omp critical
        error = std::current_exception();
      }
    }
    if (error) std::rethrow_exception(error);
    return results;
  }

  std::shared_ptr<const ClothModel> model_;
  std::vector<StepSolver> solvers_;
};

// Solves for the equilibrium from x.
using Newton = std::function<EquilibriumResult(
    const MaterialField& material, const Eigen::VectorXd& x, const EquilibriumOptions& options)>;

EquilibriumResult RaiseLoad(const Newton& newton, const Eigen::VectorXd& rest_x,
                            const MaterialField& material, const EquilibriumOptions& options) {
  constexpr double kFirstShare = 1.0 / 15, kMinStep = 1e-3;
  EquilibriumResult reached;
  reached.x = rest_x;
  for (double share = 0.0, step = kFirstShare; share < 1.0;) {
    const double next = std::min(1.0, share + step);
    EquilibriumOptions of_share = options;
    // The rounding errors of the forces grow in proportion to the stiffness of the cloth.
    of_share.tolerance = options.tolerance / next;
    EquilibriumResult trial = newton(Scaled(material, 1.0 / next, 1.0 / next), reached.x, of_share);
    trial.iterations += reached.iterations;
    trial.factorisations += reached.factorisations;
    if (trial.status == EquilibriumStatus::kCancelled) return trial;
    if (trial.status == EquilibriumStatus::kStable) {
      reached = std::move(trial);
      share = next;
      step *= 2.0;
      continue;
    }
    reached.iterations = trial.iterations;
    reached.factorisations = trial.factorisations;
    step = 0.25 * (next - share);
    if (step < kMinStep) {
      reached.status = EquilibriumStatus::kNotConverged;
      reached.load_share = share;
      break;
    }
  }
  return reached;
}

}  // namespace

std::unique_ptr<Backend> MakeCpuBackend(std::shared_ptr<const ClothModel> model, int threads) {
  return std::make_unique<CpuBackend>(std::move(model), threads);
}

EquilibriumResult SolveFromRest(StepSolver& solver, const MaterialField& material,
                                const EquilibriumOptions& options) {
  const auto newton = [&](const MaterialField& stiffer, const Eigen::VectorXd& x,
                          const EquilibriumOptions& of_share) {
    return SolveEquilibrium(solver, stiffer, x, of_share);
  };
  return RaiseLoad(newton, solver.model().mesh.rest_x, material, options);
}

EquilibriumResult SolveFromRest(Backend& backend, const MaterialField& material,
                                const EquilibriumOptions& options) {
  const auto newton = [&](const MaterialField& stiffer, const Eigen::VectorXd& x,
                          const EquilibriumOptions& of_share) {
    const State start{x, Eigen::VectorXd::Zero(x.size())};
    const RolloutInput input{&stiffer, &start};
    return std::move(backend.Equilibria({&input, 1}, of_share)[0]);
  };
  return RaiseLoad(newton, backend.model().mesh.rest_x, material, options);
}

}  // namespace drape
