// SPDX-License-Identifier: Apache-2.0
#include "physics/statics.h"

#include <algorithm>
#include <cmath>

#include "physics/assembly.h"

namespace drape {
namespace {

// Of a drape that counts as stable: nearer to a fold bifurcation Ks⁻¹ lets the skew part of K rule.
constexpr double kMaxAsymmetry = 0.5;

constexpr double kStandardGravity = 9.8;  // weighs a cloth whose scene has none [m/s²]

double Weight(const ClothModel& model, const MaterialField& material) {
  const double gravity = model.scene.gravity ? model.scene.gravity->norm() : 0.0;
  return (gravity > 0.0 ? gravity : kStandardGravity) * material.density * model.vertex_area.sum();
}

// A shape, and what is known of it.
struct Iterate {
  Eigen::VectorXd x, force;
  double residual = 0.0, energy = 0.0;
  StressField stress;
};

class EquilibriumSearch {
 public:
  EquilibriumSearch(StepSolver& solver, const MaterialField& material,
                    const EquilibriumOptions& options)
      : solver_(solver), material_(material), options_(options), stiffness_(solver, material),
        weight_(Weight(solver.model(), material)), radius_(options.first_radius) {}

  EquilibriumResult Run(const Eigen::VectorXd& x) {
    here_ = best_ = At(x);
    stress_ = here_.stress;
    result_.start_energy = here_.energy;
    while (!(here_.residual <= options_.tolerance)) {
      if (options_.cancel != nullptr && options_.cancel->load()) {
        result_.status = EquilibriumStatus::kCancelled;
        return Finish(best_);
      }
      if (result_.iterations == options_.max_iterations || radius_ < kLeastRadius || !Step())
        return Finish(best_);
      ++result_.iterations;
    }
    stiffness_.Assemble(here_.x);
    ++result_.factorisations;
    const bool stable = stiffness_.Factor() && stiffness_.Asymmetry() < kMaxAsymmetry;
    result_.status = stable ? EquilibriumStatus::kStable : EquilibriumStatus::kUnstable;
    return Finish(here_);
  }

 private:
  Iterate At(const Eigen::VectorXd& x) const {
    const ClothModel& model = solver_.model();
    Iterate at{.x = x, .force = {}, .stress = MembraneStress(model, material_, x)};
    AssembleForce(model, material_, x, at.force);
    at.residual = at.force.norm() / weight_;
    at.energy = Energy(model, material_, x);
    return at;
  }

  // One Newton step from here_. False when no shift makes K positive definite.
  bool Step() {
    stiffness_.Assemble(here_.x);
    StressField change = stress_;
    for (std::size_t f = 0; f < change.size(); ++f) change[f] -= here_.stress[f];
    stiffness_.AddStress(change);
    const int before = result_.factorisations;
    if (!stiffness_.FactorShifted(options_.shift, &shift_, &result_.factorisations)) return false;
    const bool raised = result_.factorisations > before + 1;
    Eigen::VectorXd dx = here_.force;
    solver_.linear().Solve(dx);
    const double move = dx.cwiseAbs().maxCoeff();
    const bool shortened = move > radius_;
    if (shortened) dx *= radius_ / move;
    stress_ = ExtrapolatedMembraneStress(solver_.model(), material_, here_.x, dx);
    result_.steps.push_back({here_.residual, 0.0, shift_, false});
    here_ = At(here_.x + dx);
    was_shortened_ = was_shortened_ || shortened;
    AcceptOrTakeBack(std::min(move, radius_));
    if (shortened) {
      shift_ = std::max(shift_, options_.shift.first);
    } else if (!raised) {
      shift_ *= kShiftDecay;
      if (shift_ < 0.2 * options_.shift.first) shift_ = 0.0;
    }
    return true;
  }

  // Where the energy no longer resolves the progress, or is none (its stretch part is held at the
  // present stiffness), the residual counts.
  bool IsBetter() const {
    return here_.energy < best_.energy || (best_.residual < options_.residual_regime &&
                                           here_.residual < kResidualDecrease * best_.residual);
  }

  void AcceptOrTakeBack(double move) {
    result_.steps.back().energy = here_.energy;
    if (IsBetter()) {
      result_.steps.back().accepted = true;
      if (was_shortened_ && excursion_ <= 1)
        radius_ = std::min(options_.max_radius, kRadiusGrowth * radius_);
      best_ = here_;
    } else if (++excursion_ <= kLongestExcursion && std::isfinite(here_.energy)) {
      return;
    } else {
      here_ = best_;
      radius_ = kRadiusDecay * move;
    }
    stress_ = here_.stress;
    excursion_ = 0;
    was_shortened_ = false;
  }

  EquilibriumResult Finish(const Iterate& at) {
    result_.x = at.x;
    result_.residual = at.residual;
    return std::move(result_);
  }

  static constexpr int kLongestExcursion = 8;  // steps above the lowest energy
  static constexpr double kRadiusGrowth = 1.5, kRadiusDecay = 0.35, kLeastRadius = 1e-9;  // [m]
  static constexpr double kShiftDecay = 0.25;
  static constexpr double kResidualDecrease = 0.9;

  StepSolver& solver_;
  const MaterialField& material_;
  const EquilibriumOptions& options_;
  Stiffness stiffness_;
  double weight_;
  double radius_;
  double shift_ = 0.0;
  Iterate here_, best_;   // the present shape; the last accepted one
  StressField stress_;    // of the geometric stiffness at here_
  int excursion_ = 0;     // steps since best_
  bool was_shortened_ = false;  // one of these
  EquilibriumResult result_;
};

}  // namespace

const char* ToString(EquilibriumStatus status) {
  switch (status) {
    case EquilibriumStatus::kStable: return "stable";
    case EquilibriumStatus::kUnstable: return "unstable";
    case EquilibriumStatus::kNotConverged: return "not converged";
    case EquilibriumStatus::kCancelled: return "cancelled";
  }
  return "unknown";
}

double ForceResidual(const ClothModel& model, const MaterialField& material,
                     const Eigen::VectorXd& x) {
  Eigen::VectorXd force;
  AssembleForce(model, material, x, force);
  return force.norm() / Weight(model, material);
}

EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options) {
  return EquilibriumSearch(solver, material, options).Run(x);
}

bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x, RowMatrix* dx) {
  const ClothModel& model = solver.model();
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  if (!stiffness.Factor()) return false;
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  RowMatrix by_entry = RowMatrix::Zero(model.num_dofs(), kMaterialEntries);
  AddMaterialColumns(model, material, weight, x, no_velocity, 1.0, by_entry);
  return stiffness.Solve(by_entry, dx);
}

bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                        const RowMatrix& seeds, MaterialGradient* gradient) {
  const ClothModel& model = solver.model();
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  RowMatrix lambda;
  if (!stiffness.Factor() || !stiffness.SolveTransposed(seeds, &lambda)) return false;
  *gradient = MaterialGradient::Zero(material, static_cast<int>(seeds.cols()));
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  AddMaterialGradient(model, material, x, no_velocity, 1.0, lambda, *gradient);
  return true;
}

}  // namespace drape
