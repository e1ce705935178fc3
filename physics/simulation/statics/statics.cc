// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/statics/statics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/dynamics.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {
namespace {

constexpr int kMaxNonMonotoneSteps = 8;  // consecutive steps above the lowest energy
constexpr double kRadiusGrowth = 1.5, kRadiusDecay = 0.35, kMinRadius = 1e-9;  // [m]
constexpr double kShiftDecay = 0.25, kMinShift = 0.2;  // kMinShift × StiffnessShift::first
constexpr double kResidualDecrease = 0.9;
// Rounding keeps the residual of stiff cloth above the tolerance: below this, so many steps in a
// row that do not lower it have converged.
constexpr double kRoundedResidual = 1e-7;
constexpr int kRoundedSteps = 4;

// Largest asymmetry of a drape that counts as stable [MODEL, M36]. Nearer to a fold bifurcation the
// skew part of K dominates, and Newton's method with a factor of Ks alone no longer converges.
constexpr double kMaxAsymmetry = 1.0;

// A shape with its force, its energy and the states of its elements.
struct Iterate {
  Eigen::VectorXd x, force;
  double residual = 0.0, energy = 0.0;
  ElementStates elements;
};

class EquilibriumSearch {
 public:
  EquilibriumSearch(StepSolver& solver, const MaterialField& material,
                    const EquilibriumOptions& options, const Eigen::VectorXd& x,
                    const StepMatrix& matrix)
      : solver_(solver),
        material_(material),
        matrix_(matrix),
        shift_length_(options.shift.length),
        stiffness_(solver, material),
        weight_(CharacteristicForce(solver.model(), material)),
        here_(At(x)),
        best_(here_),
        stress_(MembraneStress(here_->elements)),
        start_energy_(here_->energy),
        control_(options, here_->residual, here_->energy),
        interruptible_(solver.own_linear(), options.cancel) {}

  EquilibriumResult Run() {
    for (;;) {
      switch (control_.Next()) {
        case NewtonNext::kStep:
          Step();
          break;
        case NewtonNext::kConverged: {
          const EquilibriumStatus status = control_.Conclude(AsymmetryHere());
          return Result(control_.Cancelled() ? EquilibriumStatus::kCancelled : status, *here_);
        }
        case NewtonNext::kCancelled:
          return Result(EquilibriumStatus::kCancelled, *best_);
        case NewtonNext::kGiveUp:
          return Result(EquilibriumStatus::kNotConverged, *best_);
      }
    }
  }

 private:
  std::shared_ptr<const Iterate> At(const Eigen::VectorXd& x) const {
    const ClothModel& model = solver_.model();
    auto at = std::make_shared<Iterate>();
    at->x = x;
    at->elements =
        EvaluateElements(model, material_, x, at->force, solver_.self_contact(), solver_.parts());
    at->residual = at->force.norm() / weight_;
    at->energy = Energy(model, material_.density, at->elements, x, solver_.self_contact());
    return at;
  }

  void Step() {
    if (!FactorHere()) return;
    Eigen::VectorXd dx = here_->force;
    solver_.linear().Solve(dx);
    dx *= control_.Scale(dx.cwiseAbs().maxCoeff());
    if (solver_.model().scene.contact) ShortenMoves(*solver_.model().scene.contact, here_->x, dx);
    if (solver_.self_contact() != nullptr && dx.allFinite())
      was_held_up_ = LimitStep(*solver_.self_contact(), here_->x, dx);
    stress_ = ExtrapolatedMembraneStress(solver_.model(), here_->elements, here_->x, dx);
    here_ = At(here_->x + dx);
    switch (control_.Judge(here_->residual, here_->energy)) {
      case NewtonVerdict::kNonMonotone:
        return;
      case NewtonVerdict::kAccept:
        best_ = here_;
        break;
      case NewtonVerdict::kRejectStep:
        here_ = best_;
        break;
    }
    stress_ = MembraneStress(here_->elements);
  }

  // Factors K at here_ with the geometric stiffness of stress_, shifted where necessary. Returns
  // false when no shift makes it positive definite. Where the cloth touches itself, the whole
  // curvature of that converges quadratically near the end and is not positive definite far from it
  // [MODEL, M62].
  bool FactorHere() {
    double mu = control_.FirstShift();
    if (matrix_) return FactorStepMatrix();
    const bool touches = TouchesItself();
    if (touches && !was_held_up_) {
      stiffness_.AssembleSymmetric(here_->elements, stress_, here_->x, StiffnessPart::kWhole);
      if (stiffness_.FactorShifted(shift_length_, &mu, [](double) { return std::nullopt; }))
        return true;
    }
    stiffness_.AssembleSymmetric(here_->elements, stress_, here_->x,
                                 touches ? StiffnessPart::kPositive : StiffnessPart::kWhole);
    return stiffness_.FactorShifted(shift_length_, &mu,
                                    [this](double) { return control_.NextShift(); });
  }

  bool FactorStepMatrix() {
    BlockMatrix matrix(solver_.model().pattern);
    matrix_(here_->x, matrix);
    if (solver_.linear().Factor(matrix)) return true;
    control_.NextShift();
    return false;
  }

  bool TouchesItself() {
    SurfaceContact* const self = solver_.self_contact();
    return self != nullptr && here_->x.allFinite() && !self->FindActivePairs(here_->x).empty();
  }

  std::optional<double> AsymmetryHere() {
    stiffness_.Assemble(here_->x);
    if (!stiffness_.Factor()) return std::nullopt;
    return stiffness_.Asymmetry();
  }

  EquilibriumResult Result(EquilibriumStatus status, const Iterate& at) const {
    return {.status = status,
            .x = at.x,
            .iterations = control_.iterations(),
            .factorisations = control_.factorisations(),
            .residual = at.residual,
            .start_energy = start_energy_,
            .steps = control_.steps()};
  }

  StepSolver& solver_;
  const MaterialField& material_;
  const StepMatrix& matrix_;
  double shift_length_;
  Stiffness stiffness_;
  double weight_;
  std::shared_ptr<const Iterate> here_, best_;  // the present shape; the last accepted one
  StressField stress_;                          // of the geometric stiffness at here_
  double start_energy_;
  NewtonControl control_;
  bool was_held_up_ = false;  // the last step, by the cloth itself
  Interruptible interruptible_;
};

// ∂f/∂entry · weight, shape [3V, 39].
RowMatrix ForceByEntry(const ClothModel& model, const MaterialField& material,
                       const MaterialField& weight, const Eigen::VectorXd& x) {
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  RowMatrix by_entry = RowMatrix::Zero(model.num_dofs(), kMaterialEntries);
  AddMaterialColumns(model, material, weight, x, no_velocity, 1.0, by_entry);
  return by_entry;
}

}  // namespace

const char* ToString(EquilibriumStatus status) {
  switch (status) {
    case EquilibriumStatus::kStable:
      return "stable";
    case EquilibriumStatus::kUnstable:
      return "unstable";
    case EquilibriumStatus::kNotConverged:
      return "not converged";
    case EquilibriumStatus::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

NewtonControl::NewtonControl(const EquilibriumOptions& options, double residual, double energy)
    : options_(options),
      here_{residual, energy},
      best_(here_),
      radius_(options.first_radius),
      least_residual_(residual) {}

NewtonNext NewtonControl::Next() const {
  if (here_.residual <= options_.tolerance ||
      (here_.residual <= kRoundedResidual && rounded_steps_ >= kRoundedSteps))
    return NewtonNext::kConverged;
  if (Cancelled()) return NewtonNext::kCancelled;
  if (no_shift_left_ || iterations() == options_.max_iterations || radius_ < kMinRadius)
    return NewtonNext::kGiveUp;
  return NewtonNext::kStep;
}

double NewtonControl::FirstShift() {
  was_raised_ = false;
  ++factorisations_;
  return shift_;
}

std::optional<double> NewtonControl::NextShift() {
  const std::optional<double> next = Cancelled() ? std::nullopt : options_.shift.After(shift_);
  no_shift_left_ = !next;
  if (!next) return next;
  was_raised_ = true;
  ++factorisations_;
  return shift_ = *next;
}

double NewtonControl::Scale(double move) {
  was_shortened_ = move > radius_;
  excursion_was_shortened_ = excursion_was_shortened_ || was_shortened_;
  move_ = std::min(move, radius_);
  return was_shortened_ ? radius_ / move : 1.0;
}

NewtonVerdict NewtonControl::Judge(double residual, double energy) {
  const Shape shape{residual, energy};
  const bool lowers = residual < kResidualDecrease * least_residual_;
  rounded_steps_ = residual <= kRoundedResidual && !lowers ? rounded_steps_ + 1 : 0;
  least_residual_ = std::min(residual, least_residual_);
  const bool better = IsBetter(shape);
  steps_.push_back({here_.residual, energy, shift_, better});
  AdaptShift();
  here_ = shape;
  if (better) {
    if (excursion_was_shortened_ && excursion_ <= 1)
      radius_ = std::min(options_.max_radius, kRadiusGrowth * radius_);
    best_ = here_;
    return EndNonMonotone(NewtonVerdict::kAccept);
  }
  if (++excursion_ <= kMaxNonMonotoneSteps && std::isfinite(energy))
    return NewtonVerdict::kNonMonotone;
  here_ = best_;
  radius_ = kRadiusDecay * move_;
  return EndNonMonotone(NewtonVerdict::kRejectStep);
}

EquilibriumStatus NewtonControl::Conclude(std::optional<double> asymmetry) {
  ++factorisations_;
  return asymmetry && *asymmetry < kMaxAsymmetry ? EquilibriumStatus::kStable
                                                 : EquilibriumStatus::kUnstable;
}

// The residual decides where the energy no longer resolves the progress, or where no energy exists
// (its stretch part is held at the present stiffness).
bool NewtonControl::IsBetter(const Shape& shape) const {
  return shape.energy < best_.energy || (best_.residual < options_.residual_regime &&
                                         shape.residual < kResidualDecrease * best_.residual);
}

void NewtonControl::AdaptShift() {
  if (was_shortened_) {
    shift_ = std::max(shift_, options_.shift.first);
  } else if (!was_raised_) {
    shift_ *= kShiftDecay;
    if (shift_ < kMinShift * options_.shift.first) shift_ = 0.0;
  }
}

NewtonVerdict NewtonControl::EndNonMonotone(NewtonVerdict verdict) {
  excursion_ = 0;
  excursion_was_shortened_ = false;
  return verdict;
}

double CharacteristicForce(const ClothModel& model, const MaterialField& material) {
  constexpr double kStandardGravity = 9.8;  // [m/s²]
  const double gravity = model.scene.gravity ? model.scene.gravity->norm() : 0.0;
  return (gravity > 0.0 ? gravity : kStandardGravity) * material.density * model.vertex_area.sum();
}

double ForceResidual(const ClothModel& model, const MaterialField& material,
                     const Eigen::VectorXd& x) {
  Eigen::VectorXd force;
  AssembleForce(model, material, x, force);
  return force.norm() / CharacteristicForce(model, material);
}

EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options,
                                   const StepMatrix& matrix) {
  const std::optional<Contact>& contact = solver.model().scene.contact;
  solver.Forget();
  if (!contact) return EquilibriumSearch(solver, material, options, x, matrix).Run();
  Eigen::VectorXd outside = x;
  PushOut(*contact, outside);
  if (contact->self && (!outside.allFinite() || FindSelfOverlap(solver.model(), outside))) {
    EquilibriumResult none;
    none.x = x;
    none.residual = std::numeric_limits<double>::infinity();
    return none;
  }
  return EquilibriumSearch(solver, material, options, outside, matrix).Run();
}

bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                        const MaterialField& weight, const Eigen::VectorXd& x, RowMatrix* dx,
                        bool dynamics) {
  const ClothModel& model = solver.model();
  RowMatrix by_number = ForceByEntry(model, material, weight, x);
  if (dynamics) {
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(x.size());
    MaterialField at_rest = material;
    at_rest.dynamics = {};
    by_number.conservativeResize(Eigen::NoChange, kMaterialEntries + kDynamicsEntries);
    by_number.rightCols<kDynamicsEntries>() =
        DynamicsColumns(model, at_rest, {.x = x, .v = still, .w = still, .h = 1.0});
  }
  solver.Forget();
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  return stiffness.Factor() && stiffness.Solve(by_number, dx);
}

bool EquilibriumJvpColumn(StepSolver& solver, const MaterialField& material,
                          const MaterialField& change, const Eigen::VectorXd& x,
                          Eigen::VectorXd* dx) {
  solver.Forget();
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  RowMatrix column;
  if (!stiffness.Factor() ||
      !stiffness.Solve(ForceByEntry(solver.model(), material, change, x).rowwise().sum(), &column))
    return false;
  *dx = column;
  return true;
}

bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                        const RowMatrix& dL_dx, MaterialGradient* gradient) {
  const ClothModel& model = solver.model();
  solver.Forget();
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  RowMatrix lambda;
  if (!stiffness.Factor() || !stiffness.SolveTransposed(dL_dx, &lambda)) return false;
  *gradient = MaterialGradient::Zero(material, static_cast<int>(dL_dx.cols()));
  const Eigen::VectorXd no_velocity = Eigen::VectorXd::Zero(x.size());
  AddMaterialGradient(model, material, x, no_velocity, 1.0, lambda, *gradient);
  return true;
}

}  // namespace drape
