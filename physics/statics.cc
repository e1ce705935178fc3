// SPDX-License-Identifier: Apache-2.0
#include "physics/statics.h"

#include <algorithm>

#include "physics/assembly.h"

namespace drape {
namespace {

// Above it derivatives would need more rounds than they are worth: 40 rounds reach 1e-10 at 0.56.
constexpr double kMaxRefinementRate = 0.5;

constexpr double kStandardGravity = 9.8;  // weighs a cloth whose scene has none [m/s²]

double Weight(const ClothModel& model, const MaterialField& material) {
  const double gravity = model.scene.gravity ? model.scene.gravity->norm() : 0.0;
  return (gravity > 0.0 ? gravity : kStandardGravity) * material.density * model.vertex_area.sum();
}

// ½(K + Kᵀ) of a stiffness given as −K.
void Symmetrise(const BlockPattern& pattern, const BlockMatrix& negative, BlockMatrix& K) {
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const int j = pattern.column[b];
      const auto begin = pattern.column.begin();
      const int mirror = static_cast<int>(
          std::lower_bound(begin + pattern.row_start[j], begin + pattern.row_start[j + 1], i) - begin);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          K.block(b)[3 * r + c] =
              -0.5 * (negative.block(b)[3 * r + c] + negative.block(mirror)[3 * c + r]);
    }
}

// The Newton iteration's matrix K + μM and its shift.
class ShiftedStiffness {
 public:
  ShiftedStiffness(StepSolver& solver, const MaterialField& material)
      : solver_(solver), material_(material), matrix_(solver.model().pattern),
        no_velocity_(Eigen::VectorXd::Zero(solver.model().num_dofs())) {}

  // Factors the symmetrised K at x, with the smallest shift of the schedule that is at least
  // `shift` and makes it positive definite. False when none up to max_shift does.
  bool Factor(const Eigen::VectorXd& x, double& shift, const EquilibriumOptions& options, int& count) {
    negative_ = &solver_.StepDerivative(material_, x, no_velocity_, 1.0);
    Symmetrise(solver_.model().pattern, *negative_, matrix_);
    AddMass(shift);
    while (++count, !solver_.linear().Factor(matrix_)) {
      const double next = std::max(4.0 * shift, options.first_shift);
      if (next > options.max_shift) return false;
      AddMass(next - shift);
      shift = next;
    }
    return true;
  }
  bool FactorUnshifted(const Eigen::VectorXd& x) {
    EquilibriumOptions unshifted;
    unshifted.max_shift = 0.0;
    double none = 0.0;
    int count = 0;
    return Factor(x, none, unshifted, count);
  }

  // K·solution = rhs, or Kᵀ·solution = rhs, to 1e-10, or to rounding where a slender strip is so much
  // stiffer in its plane than across it that products with K lose more: `add_multiply` is the
  // product of −K that goes with it. False when the refinement does not contract. Needs an unshifted
  // Factor.
  bool SolveRefined(decltype(AddMultiply)& add_multiply, const RowMatrix& rhs, RowMatrix* solution) {
    constexpr int kMaxRounds = 40;
    constexpr double kRefined = 1e-10, kRoundingAtMost = 1e-6, kStandsStill = 0.9;
    RowMatrix defect = rhs;
    double before = rhs.norm();
    solution->setZero(rhs.rows(), rhs.cols());
    for (int round = 0; round < kMaxRounds; ++round) {
      solver_.linear().Solve(defect);
      *solution += defect;
      defect = rhs;
      add_multiply(solver_.model().pattern, *negative_, *solution, defect);
      const double now = defect.norm();
      if (now <= kRefined * rhs.norm()) return true;
      if (now <= kRoundingAtMost * rhs.norm() && now > kStandsStill * before) return true;
      before = now;
    }
    return false;
  }

  // Rate at which refinement of the factored symmetric part to K itself converges, estimated by
  // power iteration; ≥ 1 means never. Needs an unshifted Factor.
  double RefinementRate() {
    constexpr int kRounds = 8;
    const BlockPattern& pattern = solver_.model().pattern;
    RowMatrix direction = RowMatrix::Ones(no_velocity_.size(), 1), defect;
    double rate = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      defect = RowMatrix::Zero(direction.rows(), 1);
      AddMultiply(pattern, *negative_, direction, defect);
      solver_.linear().Solve(defect);  // −Ks⁻¹·K·d
      defect += direction;
      rate = defect.norm() / direction.norm();
      direction = defect / defect.norm();
    }
    return rate;
  }

 private:
  void AddMass(double shift) {
    const ClothModel& model = solver_.model();
    for (int i = 0; i < model.mesh.num_vertices(); ++i)
      matrix_.AddScaledIdentity(model.pattern.diagonal[i],
                                shift * material_.density * model.vertex_area[i]);
  }

  StepSolver& solver_;
  const MaterialField& material_;
  BlockMatrix matrix_;
  const BlockMatrix* negative_ = nullptr;
  Eigen::VectorXd no_velocity_;
};

// Backtracks along dx until the energy falls enough or, near the end where the energy no longer
// resolves the progress, the residual does. `energy` is that of x, before and after. Returns the
// halvings, or −1.
int LineSearch(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& force,
               bool near_rest, const Eigen::VectorXd& dx, Eigen::VectorXd& x, double& energy) {
  constexpr int kMaxHalvings = 20;
  constexpr double kArmijo = 1e-4, kResidualDecrease = 0.9;
  const double slope = force.dot(dx);
  Eigen::VectorXd trial, trial_force;
  double step = 1.0;
  for (int halving = 0; halving <= kMaxHalvings; ++halving, step *= 0.5) {
    trial = x + step * dx;
    const double trial_energy = Energy(model, material, trial);
    bool accept = trial_energy <= energy - kArmijo * step * slope;
    if (!accept && near_rest) {
      AssembleForce(model, material, trial, trial_force);
      accept = trial_force.norm() < kResidualDecrease * force.norm();
    }
    if (!accept) continue;
    x = trial;
    energy = trial_energy;
    return halving;
  }
  return -1;
}

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

double ForceResidual(const ClothModel& model, const MaterialField& material, const Eigen::VectorXd& x) {
  Eigen::VectorXd force;
  AssembleForce(model, material, x, force);
  return force.norm() / Weight(model, material);
}

bool FactorStiffness(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                     double* shift) {
  int count = 0;
  *shift = 0.0;
  return ShiftedStiffness(solver, material).Factor(x, *shift, {}, count);
}

EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options) {
  const ClothModel& model = solver.model();
  const double weight = Weight(model, material);
  ShiftedStiffness stiffness(solver, material);
  EquilibriumResult result;
  result.x = x;
  Eigen::VectorXd force, dx;
  double shift = 0.0, energy = Energy(model, material, x);
  result.start_energy = energy;
  for (;; ++result.iterations) {
    AssembleForce(model, material, result.x, force);
    result.residual = force.norm() / weight;
    if (result.residual <= options.tolerance) break;
    if (options.cancel != nullptr && options.cancel->load()) {
      result.status = EquilibriumStatus::kCancelled;
      return result;
    }
    if (result.iterations == options.max_iterations || !(result.residual < 1e6)) return result;
    const int before = result.factorisations;
    if (!stiffness.Factor(result.x, shift, options, result.factorisations)) return result;
    const double factored = shift;
    const bool raised = result.factorisations > before + 1;
    dx = force;
    solver.linear().Solve(dx);
    const double move = dx.cwiseAbs().maxCoeff();
    if (move > options.max_move) dx *= options.max_move / move;
    const bool near_rest = result.residual < options.residual_regime;
    const int halvings = LineSearch(model, material, force, near_rest, dx, result.x, energy);
    result.steps.push_back({result.residual, energy, factored, halvings});
    if (halvings < 0) {
      shift = std::max(10.0 * shift, options.first_shift);
      if (shift > options.max_shift) return result;
    } else if (halvings > 0) {
      shift = std::max(2.0 * shift, options.first_shift);
    } else if (!raised) {
      shift *= 0.25;
      if (shift < 0.2 * options.first_shift) shift = 0.0;
    }
  }
  ++result.factorisations;
  const bool stable = stiffness.FactorUnshifted(result.x) &&
                      stiffness.RefinementRate() < kMaxRefinementRate;
  result.status = stable ? EquilibriumStatus::kStable : EquilibriumStatus::kUnstable;
  return result;
}

bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x, RowMatrix* dx) {
  const ClothModel& model = solver.model();
  ShiftedStiffness stiffness(solver, material);
  if (!stiffness.FactorUnshifted(x)) return false;
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  RowMatrix by_entry = RowMatrix::Zero(model.num_dofs(), kMaterialEntries);
  AddMaterialColumns(model, material, weight, x, no_velocity, 1.0, by_entry);
  return stiffness.SolveRefined(AddMultiply, by_entry, dx);
}

bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                        const RowMatrix& seeds, MaterialGradient* gradient) {
  const ClothModel& model = solver.model();
  ShiftedStiffness stiffness(solver, material);
  RowMatrix lambda;
  if (!stiffness.FactorUnshifted(x) ||
      !stiffness.SolveRefined(AddTransposeMultiply, seeds, &lambda)) {
    return false;
  }
  *gradient = MaterialGradient::Zero(material, static_cast<int>(seeds.cols()));
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  AddMaterialGradient(model, material, x, no_velocity, 1.0, lambda, *gradient);
  return true;
}

}  // namespace drape
