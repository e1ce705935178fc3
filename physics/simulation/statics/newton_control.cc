// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/statics/newton_control.h"

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

constexpr int kMaxNonMonotoneSteps = 8;  // consecutive steps above the lowest energy
constexpr double kRadiusGrowth = 1.5, kRadiusDecay = 0.35, kMinRadius = 1e-9;  // [m]
constexpr double kShiftDecay = 0.25, kMinShift = 0.2;  // kMinShift × StiffnessShift::first
constexpr double kResidualDecrease = 0.9;

// Largest asymmetry of a drape that counts as stable [MODEL, M36]. Nearer to a fold bifurcation the
// skew part of K dominates, and Newton's method with a factor of Ks alone no longer converges.
constexpr double kMaxAsymmetry = 1.0;

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
    : options_(options), here_{residual, energy}, best_(here_), radius_(options.first_radius) {}

NewtonNext NewtonControl::Next() const {
  if (here_.residual <= options_.tolerance) return NewtonNext::kConverged;
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

}  // namespace drape
