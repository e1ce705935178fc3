// SPDX-License-Identifier: Apache-2.0
#include "physics/modes.h"

#include <Spectra/SymEigsShiftSolver.h>
#include <glog/logging.h>

#include <algorithm>
#include <stdexcept>

#include "physics/stiffness.h"
#include "physics/stiffness_shift.h"

namespace drape {
namespace {

// (M^-½·K·M^-½ − σ)⁻¹ = M^½·(K − σM)⁻¹·M^½ with a factor of K − σM that is there.
class ShiftInvert {
 public:
  using Scalar = double;

  ShiftInvert(LinearSolver& linear, const Eigen::VectorXd& mass)
      : linear_(linear), root_mass_(mass.cwiseSqrt()) {}

  Eigen::Index rows() const { return root_mass_.size(); }
  Eigen::Index cols() const { return root_mass_.size(); }
  void set_shift(double) {}  // factored before
  void perform_op(const double* in, double* out) const {
    Eigen::VectorXd y = root_mass_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(in, rows()));
    linear_.Solve(y);
    Eigen::Map<Eigen::VectorXd>(out, rows()) = root_mass_.cwiseProduct(y);
  }

 private:
  LinearSolver& linear_;
  Eigen::VectorXd root_mass_;
};

}  // namespace

Eigen::VectorXd LowestEigenvalues(StepSolver& solver, const MaterialField& material,
                                  const Eigen::VectorXd& x, int count) {
  constexpr int kMaxRestarts = 1000;
  constexpr double kTolerance = 1e-10;
  const int n = solver.model().num_dofs();
  CHECK(count >= 1 && count < n) << count;
  double shift = 0.0;
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  const auto next = [](double failed) { return StiffnessShift{}.After(failed); };
  if (!stiffness.FactorShifted(0.0, &shift, next)) return {};
  ShiftInvert inverse(solver.linear(), solver.model().LumpedMass(material.density));
  const int subspace = std::min(n, std::max(2 * count + 1, 20));
  Spectra::SymEigsShiftSolver<ShiftInvert> lanczos(inverse, count, subspace, -shift);
  try {
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance,
                    Spectra::SortRule::SmallestAlge);
  } catch (const std::runtime_error&) {  // its dense algebra, of numbers that are not finite
    return {};
  }
  if (lanczos.info() != Spectra::CompInfo::Successful) return {};
  return lanczos.eigenvalues();
}

}  // namespace drape
