// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/statics/modes.h"

#include <Spectra/SymEigsShiftSolver.h>
#include <Spectra/SymEigsSolver.h>
#include <glog/logging.h>

#include <algorithm>
#include <functional>
#include <stdexcept>

#include "physics/simulation/statics/newton_control.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {
namespace {

// (M^-½·K·M^-½ − σ)⁻¹ = M^½·(K − σM)⁻¹·M^½ with an existing factor of K − σM.
class ShiftInvert {
 public:
  using Scalar = double;

  ShiftInvert(LinearSolver& linear, const Eigen::VectorXd& mass)
      : linear_(linear), root_mass_(mass.cwiseSqrt()) {}

  Eigen::Index rows() const { return root_mass_.size(); }
  Eigen::Index cols() const { return root_mass_.size(); }
  void set_shift(double) {}  // already factored
  void perform_op(const double* in, double* out) const {
    if (linear_.cancelled()) throw std::runtime_error("cancelled");
    Eigen::VectorXd y = root_mass_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(in, rows()));
    linear_.Solve(y);
    Eigen::Map<Eigen::VectorXd>(out, rows()) = root_mass_.cwiseProduct(y);
  }

 private:
  LinearSolver& linear_;
  Eigen::VectorXd root_mass_;
};

// M^-½·½(K + Kᵀ)·M^-½ of a stiffness given as −K.
class ScaledStiffness {
 public:
  using Scalar = double;

  ScaledStiffness(const BlockPattern& pattern, const BlockMatrix& negative,
                  const Eigen::VectorXd& mass)
      : pattern_(pattern), negative_(negative), scale_(mass.cwiseSqrt().cwiseInverse()) {}

  Eigen::Index rows() const { return scale_.size(); }
  Eigen::Index cols() const { return scale_.size(); }
  void perform_op(const double* in, double* out) const {
    const RowMatrix x = scale_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(in, rows()));
    RowMatrix sum = RowMatrix::Zero(rows(), 1);
    AddMultiply(pattern_, negative_, x, sum);
    AddTransposeMultiply(pattern_, negative_, x, sum);
    Eigen::Map<Eigen::VectorXd>(out, rows()) = -0.5 * scale_.cwiseProduct(sum.col(0));
  }

 private:
  const BlockPattern& pattern_;
  const BlockMatrix& negative_;
  Eigen::VectorXd scale_;
};

using Lanczos = Spectra::SymEigsShiftSolver<ShiftInvert>;
constexpr int kMaxRestarts = 1000;

// Calls `found` with the iteration for the lowest eigenvalues if it converges.
void FindLowest(StepSolver& solver, const MaterialField& material, const Eigen::VectorXd& x,
                int count, const std::atomic<bool>* cancel,
                const std::function<void(const Lanczos&)>& found) {
  constexpr double kTolerance = 1e-10;
  const int n = solver.model().num_dofs();
  CHECK(count >= 1 && count < n) << count;
  double shift = 0.0;
  solver.Forget();
  const Interruptible interruptible(solver.own_linear(), cancel);
  Stiffness stiffness(solver, material);
  stiffness.Assemble(x);
  const auto next = [&](double failed) {
    return solver.linear().cancelled() ? std::nullopt : StiffnessShift{}.After(failed);
  };
  if (!stiffness.FactorShifted(0.0, &shift, next)) return;
  ShiftInvert inverse(solver.linear(), solver.model().LumpedMass(material.density));
  const int subspace = std::min(n, std::max(2 * count + 1, 20));
  Lanczos lanczos(inverse, count, subspace, -shift);
  try {
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, kMaxRestarts, kTolerance,
                    Spectra::SortRule::SmallestAlge);
  } catch (const std::runtime_error&) {  // cancelled, or numbers are not finite (dense algebra)
    return;
  }
  if (lanczos.info() == Spectra::CompInfo::Successful) found(lanczos);
}

}  // namespace

Eigen::VectorXd LowestEigenvalues(StepSolver& solver, const MaterialField& material,
                                  const Eigen::VectorXd& x, int count,
                                  const std::atomic<bool>* cancel) {
  Eigen::VectorXd eigenvalues;
  FindLowest(solver, material, x, count, cancel,
             [&](const Lanczos& lanczos) { eigenvalues = lanczos.eigenvalues(); });
  return eigenvalues;
}

VibrationModes LowestModes(StepSolver& solver, const MaterialField& material,
                           const Eigen::VectorXd& x, int count) {
  VibrationModes modes;
  const Eigen::VectorXd scale =
      solver.model().LumpedMass(material.density).cwiseSqrt().cwiseInverse();
  FindLowest(solver, material, x, count, nullptr, [&](const Lanczos& lanczos) {
    modes = {lanczos.eigenvalues(), scale.asDiagonal() * lanczos.eigenvectors()};
  });
  return modes;
}

std::optional<double> HighestEigenvalue(StepSolver& solver, const MaterialField& material,
                                        const Eigen::VectorXd& x) {
  constexpr int kSubspace = 20;
  constexpr double kTolerance = 1e-6;
  const ClothModel& model = solver.model();
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(x.size());
  const BlockMatrix& negative = solver.StepDerivative(material, x, still, 1.0);
  ScaledStiffness scaled(solver.wide_model().pattern, negative, model.LumpedMass(material.density));
  Spectra::SymEigsSolver<ScaledStiffness> lanczos(scaled, 1, std::min(model.num_dofs(), kSubspace));
  try {
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestAlge, kMaxRestarts, kTolerance);
  } catch (const std::runtime_error&) {  // as above
    return std::nullopt;
  }
  if (lanczos.info() != Spectra::CompInfo::Successful) return std::nullopt;
  return lanczos.eigenvalues()[0];
}

}  // namespace drape
