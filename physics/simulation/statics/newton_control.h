// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "physics/simulation/statics/stiffness_shift.h"

namespace drape {

struct EquilibriumOptions {
  double tolerance = 1e-9;                  // ‖f‖ ≤ tolerance × weight
  int max_iterations = 100;                 // Newton steps
  StiffnessShift shift = {.length = 0.03};  // where K is not positive definite
  double first_radius = 3e-3;  // largest change of a coordinate in a step, at first [m]
  double max_radius = 0.02;    // and at most
  // ‖f‖ / weight below which a step may also lower ‖f‖ instead of the energy. Under a load that
  // strains a nonlinear table by percents, no energy has its minimum at the equilibrium: infinity.
  double residual_regime = 1e-3;
  const std::atomic<bool>* cancel = nullptr;

  bool operator==(const EquilibriumOptions&) const = default;
};

enum class EquilibriumStatus {
  kStable,    // converged, K positive definite
  kUnstable,  // converged, but K has lost definiteness or its unsymmetric part rules: at or past
              // a fold bifurcation, where derivatives blow up
  kNotConverged,  // iteration limit, or no step lowers energy or residual: x is the best shape
  kCancelled
};
const char* ToString(EquilibriumStatus status);

// One Newton step.
struct NewtonStep {
  double residual;  // ‖f‖ / weight before the step
  double energy;    // after it [J]
  double shift;     // μ that was factored [s⁻²]
  bool accepted;    // lowers the energy, or near the end the residual, of all shapes before
};

enum class NewtonNext {
  kStep,
  kConverged,  // the present shape is at rest
  kCancelled,
  kGiveUp  // iteration limit, steps of no length, or no shift left
};
enum class NewtonVerdict {
  kAccept,       // the new shape is the best one
  kNonMonotone,  // it is not, but the next steps go on from it
  kRejectStep    // back to the best one
};

// The decisions of Newton's method for a drape at rest, in scalars: those who compute shapes one by
// one or in batches ask the same object. A step is
//   Next() → FirstShift(), NextShift() while a factorisation fails → Scale() → Judge().
// The geometric stiffness is that of the stress extrapolated along the step before; after kAccept
// and kRejectStep it is that of the shape itself.
class NewtonControl {
 public:
  // ‖f‖ / weight and the energy [J] of the shape to start from.
  NewtonControl(const EquilibriumOptions& options, double residual, double energy);

  NewtonNext Next() const;

  // The shift μ to factor K with first [s⁻²], and after a failed factorisation the next one; none
  // when the step cannot be done. Each is counted as a factorisation.
  double FirstShift();
  std::optional<double> NextShift();

  // The factor that shortens a step, of which no coordinate changes more than `move` [m].
  double Scale(double move);

  // Of the shape after the step, as in the constructor.
  NewtonVerdict Judge(double residual, double energy);

  // The status of a converged shape, where K was factored without a shift (one more factorisation):
  // none when it is not positive definite, else Stiffness::Asymmetry().
  EquilibriumStatus Conclude(std::optional<double> asymmetry);

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
  double move_ = 0.0;           // of the present step, shortened [m]
  bool was_shortened_ = false;  // the present step
  bool was_raised_ = false;     // its shift
  bool no_shift_left_ = false;
  int excursion_ = 0;                     // steps since best_
  bool excursion_was_shortened_ = false;  // one of these, or the present one
  int factorisations_ = 0;
  std::vector<NewtonStep> steps_;
};

}  // namespace drape
