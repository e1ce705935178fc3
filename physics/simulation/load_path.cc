// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/load_path.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "physics/material/material_scaling.h"

namespace drape {
namespace {

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
