// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <cmath>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/simulation/statics/statics.h"
#include "physics/simulation/statics/stiffness.h"
#include "solver/studies/stability/methods/integrator.h"

namespace drape {
namespace {

// Above ω² of any cloth, needles of 1 : 1000 included, so that it is reached by no shape but one
// that is lost.
constexpr double kMostShift = 1e13;  // [s⁻²]

// A shape tried for the end of a step.
struct Trial {
  Eigen::VectorXd x, unbalanced;  // [m]; f − M(x − y)/h² [N]
  double residual = 0.0;          // its norm by the weight
  // E + ½‖x − y‖²_M/h² [J], a merit: E is a potential where tables are linear.
  double potential = 0.0;
};

class ImplicitEuler final : public Integrator {
 public:
  ImplicitEuler(std::shared_ptr<const ClothModel> model, const MaterialField& material, double h,
                const ImplicitEulerOptions& options)
      : material_(material),
        h_(h),
        options_(options),
        solver_(std::move(model)),
        stiffness_(solver_, material_),
        mass_by_h2_(solver_.model().LumpedMass(material.density) / (h * h)),
        weight_(CharacteristicForce(solver_.model(), material)) {
    CHECK_GT(h, 0.0);
  }

  IntegratorStatus Advance(State& state) override {
    const Eigen::VectorXd coasted = state.x + h_ * state.v;
    Trial here = At(state.x, coasted);
    for (int i = 0; here.residual > options_.tolerance; ++i) {
      if (i == options_.max_iterations) return IntegratorStatus::kNotConverged;
      if (!std::isfinite(here.residual)) return IntegratorStatus::kNotFinite;
      if (!Factor(here.x)) return IntegratorStatus::kNotPositiveDefinite;
      Eigen::VectorXd dx = here.unbalanced;
      solver_.linear().Solve(dx);
      if (!Backtrack(coasted, dx, here)) return IntegratorStatus::kNotConverged;
    }
    state.v = (here.x - state.x) / h_;
    state.x = here.x;
    return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
  }

 private:
  Trial At(const Eigen::VectorXd& x, const Eigen::VectorXd& coasted) const {
    Trial trial{.x = x, .unbalanced = {}};
    AssembleForce(solver_.model(), material_, x, trial.unbalanced);
    const Eigen::VectorXd inertia = mass_by_h2_.cwiseProduct(x - coasted);
    trial.unbalanced -= inertia;
    trial.residual = trial.unbalanced.norm() / weight_;
    trial.potential = Energy(solver_.model(), material_, x) + 0.5 * inertia.dot(x - coasted);
    return trial;
  }

  // K + M·μ, μ = 1/h² or, where that is not positive definite, more.
  bool Factor(const Eigen::VectorXd& x) {
    double mu = 1.0 / (h_ * h_);
    stiffness_.Assemble(x);
    return stiffness_.FactorShifted(0.0, &mu, [](double failed) {
      return 4.0 * failed > kMostShift ? std::nullopt : std::optional(4.0 * failed);
    });
  }

  // Halves the step until it lowers the potential, or near the end the residual.
  bool Backtrack(const Eigen::VectorXd& coasted, const Eigen::VectorXd& dx, Trial& here) const {
    double length = 1.0;
    for (int k = 0; k <= options_.max_halvings; ++k, length *= 0.5) {
      Trial next = At(here.x + length * dx, coasted);
      const bool better = next.potential < here.potential || next.residual < 0.9 * here.residual;
      if (!better || !std::isfinite(next.residual)) continue;
      here = std::move(next);
      return true;
    }
    return false;
  }

  MaterialField material_;
  double h_;
  ImplicitEulerOptions options_;
  StepSolver solver_;
  Stiffness stiffness_;
  Eigen::VectorXd mass_by_h2_;
  double weight_;
};

}  // namespace

std::unique_ptr<Integrator> MakeImplicitEuler(std::shared_ptr<const ClothModel> model,
                                              const MaterialField& material, double h,
                                              const ImplicitEulerOptions& options) {
  return std::make_unique<ImplicitEuler>(std::move(model), material, h, options);
}

}  // namespace drape
