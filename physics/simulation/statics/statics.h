// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "physics/cloth/assembly/step_solver.h"

namespace drape {

// A positive shift of a stiffness, μ·(M + ℓ²·L) with the lumped mass M and L = ∫ρ·∇φ·∇φ
// [MODEL, M35]: ‖u‖² and ℓ²·‖∇u‖² weighted by density. ℓ > 0 suppresses wrinkles, which are the
// usual instability of a falling cloth, and leaves its soft wide motions free; an equally large
// mass shift (ℓ = 0) would stop these too.
struct StiffnessShift {
  double length = 0.0;  // ℓ [m]
  double first = 25.0;  // smallest μ > 0; it grows by factors of 4 [s⁻²]
  double most = 1e8;    // largest μ [s⁻²]

  bool operator==(const StiffnessShift&) const = default;
  // The μ to try after `mu` did not make the stiffness positive definite; std::nullopt above
  // `most`.
  std::optional<double> After(double mu) const {
    const double next = std::max(4.0 * mu, first);
    return next > most ? std::nullopt : std::optional(next);
  }
};

struct EquilibriumOptions {
  double tolerance = 1e-9;   // ‖f‖ ≤ tolerance × weight, or rounding [MODEL, M34]
  int max_iterations = 100;  // Newton steps
  StiffnessShift shift = {.length = 0.03};  // where K is not positive definite
  double first_radius = 3e-3;               // largest change of a coordinate in the first step [m]
  double max_radius = 0.02;                 // and in any step [m]
  // The value of ‖f‖ / weight below which a step may also lower ‖f‖ instead of the energy
  // [MODEL, M34]. Use infinity under a load that strains a nonlinear table by percents, where no
  // energy has its minimum at the equilibrium.
  double residual_regime = 1e-3;
  const std::atomic<bool>* cancel = nullptr;

  bool operator==(const EquilibriumOptions&) const = default;
};

enum class EquilibriumStatus {
  kStable,    // converged, K positive definite
  kUnstable,  // converged, but K is not positive definite or its skew part dominates: at or past
              // a fold bifurcation, where derivatives diverge
  kNotConverged,  // iteration limit, or no step lowers energy or residual; x is the best shape
  kCancelled
};
const char* ToString(EquilibriumStatus status);

// One Newton step.
struct NewtonStep {
  double residual;  // ‖f‖ / weight before the step
  double energy;    // after it [J]
  double shift;     // μ that was factored [s⁻²]
  bool accepted;    // the shape has the lowest energy so far or, near the end, a lower residual
};

enum class NewtonNext {
  kStep,
  kConverged,  // the present shape is an equilibrium
  kCancelled,
  kGiveUp  // iteration limit, steps of zero length, or no shift left
};
enum class NewtonVerdict {
  kAccept,       // the new shape is the best one
  kNonMonotone,  // it is not, but the next steps start from it
  kRejectStep    // return to the best one
};

// The decisions of Newton's method for an equilibrium [MODEL, M34, M35], in scalars: solvers of
// single shapes and of batches ask the same object. A step is
//   Next() → FirstShift(), NextShift() while a factorisation fails → Scale() → Judge().
// The geometric stiffness uses the stress extrapolated along the previous step; after kAccept
// and kRejectStep it uses the stress of the shape itself.
class NewtonControl {
 public:
  // Takes ‖f‖ / weight and the energy [J] of the shape to start from.
  NewtonControl(const EquilibriumOptions& options, double residual, double energy);

  NewtonNext Next() const;

  // The shift μ [s⁻²] for the first factorisation of K in a step, and the next one after a failed
  // factorisation; std::nullopt when the step cannot be computed. Each counts as a factorisation.
  double FirstShift();
  std::optional<double> NextShift();

  // The factor by which a step is shortened in which no coordinate changes by more than `move` [m].
  double Scale(double move);

  // Judges the shape after the step by its residual and energy, as in the constructor.
  NewtonVerdict Judge(double residual, double energy);

  // The status of a converged shape after a factorisation of K without a shift, which is counted
  // here [MODEL, M36]. `asymmetry` is Stiffness::Asymmetry(), or std::nullopt when K is not
  // positive definite.
  EquilibriumStatus Conclude(std::optional<double> asymmetry);

  bool Cancelled() const { return options_.cancel != nullptr && options_.cancel->load(); }
  int iterations() const { return static_cast<int>(steps_.size()); }
  int factorisations() const { return factorisations_; }
  const std::vector<NewtonStep>& steps() const { return steps_; }

 private:
  struct Shape {
    double residual, energy;
  };
  bool IsBetter(const Shape& shape) const;
  void AdaptShift();
  NewtonVerdict EndNonMonotone(NewtonVerdict verdict);

  EquilibriumOptions options_;
  Shape here_, best_;  // the present shape; the last accepted one
  double radius_;      // largest change of a coordinate [m]
  double shift_ = 0.0;
  double move_ = 0.0;           // of the present step, after shortening [m]
  bool was_shortened_ = false;  // the present step
  bool was_raised_ = false;     // its shift
  bool no_shift_left_ = false;
  double least_residual_;
  int rounded_steps_ = 0;                 // the last steps that only rounding kept from the end
  int excursion_ = 0;                     // steps since best_
  bool excursion_was_shortened_ = false;  // one of these, or the present one
  int factorisations_ = 0;
  std::vector<NewtonStep> steps_;
};

// Equilibria of the cloth, f(x) = 0, and their derivatives by the implicit function theorem
// [MODEL, M33, M43], with the exact K = −∂f/∂x of Stiffness.

struct EquilibriumResult {
  EquilibriumStatus status = EquilibriumStatus::kNotConverged;
  Eigen::VectorXd x;
  int iterations = 0;
  int factorisations = 0;
  double residual = 0.0;      // ‖f‖ / weight, with the weight of CharacteristicForce
  double start_energy = 0.0;  // [J]
  double load_share = 1.0;    // of the load that x carries; less than 1: SolveFromRest ended there
  std::vector<NewtonStep> steps;
};

// The weight of the cloth [N], to which residuals and tolerances are relative. A scene without
// gravity uses 9.8 m/s² [MODEL, M33].
double CharacteristicForce(const ClothModel& model, const MaterialField& material);

// Assembles at x the matrix that a Newton step factors instead of K, which is then never shifted.
using StepMatrix = std::function<void(const Eigen::VectorXd& x, BlockMatrix& matrix)>;

// Newton's method from x, shape [3V] [MODEL, M34–M37]. Start near the drape, never from the flat
// cloth: a drape has many stable equilibria, and this finds a near one.
// - The geometric stiffness uses the stress extrapolated along the previous step, as in a
//   mixed method with stresses as unknowns [Magisano 2017]: a finite rotation strains x + dx by
//   ½|dx|², and the stress of that would stop the next step. Steps become 3–5 times as long.
// - A step may therefore raise the energy, and the next ones lower it again. Steps that do not do
//   so within eight are rejected, and the radius is shortened (watchdog [Chamberlain 1982]).
// - K is shifted until it is positive definite.
// Where the scene has contact of the cloth with itself, no step passes through it; a start that
// does (FindSelfOverlap) is returned as not converged. matrix: of the steps; none: K.
EquilibriumResult SolveEquilibrium(StepSolver& solver, const MaterialField& material,
                                   const Eigen::VectorXd& x, const EquilibriumOptions& options,
                                   const StepMatrix& matrix = {});

// ∂x/∂p = K⁻¹·∂f/∂p at an equilibrium for the 39 entries, weighted as in AddMaterialColumns, and,
// if wanted, by the numbers of DynamicsEntry, of which only the density moves a cloth at rest;
// shape [3V, 39 or 46] [MODEL, M43]. Returns false when K is not positive definite or
// Stiffness::Solve does not converge.
[[nodiscard]] bool EquilibriumTangent(StepSolver& solver, const MaterialField& material,
                                      const MaterialField& weight, const Eigen::VectorXd& x,
                                      RowMatrix* dx, bool dynamics = false);

// dx = K⁻¹·∂f/∂p·change: the displacement of an equilibrium, to first order in a change of each
// table entry. It has the shape [3V] of one column of EquilibriumTangent. Returns false as
// EquilibriumTangent does.
[[nodiscard]] bool EquilibriumJvpColumn(StepSolver& solver, const MaterialField& material,
                                        const MaterialField& change, const Eigen::VectorXd& x,
                                        Eigen::VectorXd* dx);

// Gradients of m scalars L of an equilibrium by each entry of the tables of the material, from
// dL_dx = ∂L/∂x, shape [3V, m]: (∂f/∂p)ᵀ·K⁻ᵀ·dL_dx by one factorisation [MODEL, M43]. Returns false
// as EquilibriumTangent does.
[[nodiscard]] bool EquilibriumAdjoint(StepSolver& solver, const MaterialField& material,
                                      const Eigen::VectorXd& x, const RowMatrix& dL_dx,
                                      MaterialGradient* gradient);

// ‖f(x)‖ / weight, as in EquilibriumResult: the distance of a shape from equilibrium.
double ForceResidual(const ClothModel& model, const MaterialField& material,
                     const Eigen::VectorXd& x);

}  // namespace drape
