// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/statics/stiffness.h"

#include <Spectra/SymEigsShiftSolver.h>
#include <Spectra/SymEigsSolver.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "physics/linalg/linear_solver.h"
#include "physics/simulation/statics/statics.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

// ½(K + Kᵀ) of a stiffness given as −K.
void Symmetrise(const BlockPattern& pattern, const BlockMatrix& negative, int threads,
                BlockMatrix& K) {
#pragma omp parallel for num_threads(threads) if (threads > 1)
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const int mirror = pattern.mirror[b];
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          K.block(b)[3 * r + c] =
              -0.5 * (negative.block(b)[3 * r + c] + negative.block(mirror)[3 * c + r]);
    }
}

void AddShift(const ClothModel& model, double density, double mu, double length, BlockMatrix& K) {
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    K.AddScaledIdentity(model.pattern.diagonal[i], mu * density * model.vertex_area[i]);
  if (length == 0.0 || !model.scene.stretch) return;
  const double tension = mu * density * length * length;
  AddGeometricStiffness(model, StressField(model.mesh.num_faces(), {tension, tension, 0.0}), K);
}

// Dot products of the columns.
std::vector<double> Dots(const RowMatrix& a, const RowMatrix& b) {
  std::vector<double> dots(a.cols(), 0.0);
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index c = 0; c < a.cols(); ++c) dots[c] += a(i, c) * b(i, c);
  return dots;
}
std::vector<double> Norms(const RowMatrix& a) {
  std::vector<double> norms = Dots(a, a);
  for (double& norm : norms) norm = std::sqrt(norm);
  return norms;
}

// (x, before) ← (before + weight·(step + x − before), x), column by column.
void Advance(std::span<const double> weight, const RowMatrix& step, RowMatrix& before,
             RowMatrix& x) {
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index c = 0; c < x.cols(); ++c) {
      const double old = std::exchange(before(i, c), x(i, c));
      x(i, c) = old + weight[c] * (step(i, c) + x(i, c) - old);
    }
}

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

Stiffness::Stiffness(StepSolver& solver, const MaterialField& material)
    : solver_(solver),
      material_(material),
      weightless_(material),
      symmetric_(solver.wide_model().pattern) {
  weightless_.density = 0.0;
  weightless_.dynamics = {};
}

void Stiffness::Assemble(const Eigen::VectorXd& x) {
  negative_ = &solver_.StepDerivative(material_, x, Eigen::VectorXd::Zero(x.size()), 1.0);
  Symmetrise(solver_.wide_model().pattern, *negative_, solver_.threads(), Symmetric());
}

void Stiffness::AssembleSymmetric(const ElementStates& states, const StressField& stress,
                                  const Eigen::VectorXd& x, StiffnessPart part) {
  solver_.Widen(x);
  AssembleStiffness(solver_.wide_model(), states, stress, x, part, Symmetric(),
                    solver_.self_contact(), solver_.parts());
}

BlockMatrix& Stiffness::Symmetric() {
  const BlockPattern& pattern = solver_.wide_model().pattern;
  if (symmetric_.value.size() != 9 * pattern.column.size()) symmetric_ = BlockMatrix(pattern);
  return symmetric_;
}

void Stiffness::AssemblePositive(const Eigen::VectorXd& x) {
  Eigen::VectorXd force;
  AssembleStep(solver_.wide_model(), weightless_, x, 1.0, force, Symmetric(),
               solver_.self_contact(), solver_.parts());
}

bool Stiffness::AddBlock(int i, int j, const Eigen::Matrix3d& block) {
  return AddSymmetricBlock(solver_.wide_model().pattern, i, j, block, symmetric_);
}

bool Stiffness::Factor() { return solver_.linear().Factor(symmetric_); }

bool Stiffness::FactorShifted(double length, double* mu,
                              const std::function<std::optional<double>(double)>& next) {
  const auto add = [&](double more) {
    if (more > 0.0) AddShift(solver_.wide_model(), material_.density, more, length, symmetric_);
  };
  add(*mu);
  while (!Factor()) {
    const std::optional<double> larger = next(*mu);
    if (!larger) return false;
    add(*larger - *mu);
    *mu = *larger;
  }
  return true;
}

bool Stiffness::Solve(const RowMatrix& rhs, RowMatrix* solution) {
  return SolveWith(AddMultiply, rhs, solution);
}
bool Stiffness::SolveTransposed(const RowMatrix& rhs, RowMatrix* solution) {
  return SolveWith(AddTransposeMultiply, rhs, solution);
}

// `multiply` is the product with −K or −Kᵀ, as the system requires.
bool Stiffness::SolveWith(decltype(AddMultiply)& multiply, const RowMatrix& rhs,
                          RowMatrix* solution) {
  CgwRecurrence columns(Norms(rhs));
  *solution = RowMatrix::Zero(rhs.rows(), rhs.cols());
  RowMatrix residual = rhs(Eigen::all, columns.active()), step;
  RowMatrix x = RowMatrix::Zero(residual.rows(), residual.cols()), before = x;
  while (columns.status() == CgwStatus::kGoOn) {
    step = residual;
    solver_.linear().Solve(step);
    Advance(columns.Weights(Dots(residual, step)), step, before, x);
    residual = rhs(Eigen::all, columns.active());
    multiply(solver_.wide_model().pattern, *negative_, x, residual);
    const std::vector<int> column_of_x = columns.active();
    columns.Judge(Norms(residual));
    if (columns.kept().size() == column_of_x.size()) continue;
    (*solution)(Eigen::all, column_of_x) = x;
    for (RowMatrix* each : {&residual, &before, &x})
      *each = (*each)(Eigen::all, columns.kept()).eval();
  }
  return columns.status() == CgwStatus::kSolved;
}

RowMatrix AsymmetryStart(int dofs) {
  std::mt19937_64 random(1);
  RowMatrix direction(dofs, 1);
  for (int i = 0; i < dofs; ++i) direction(i, 0) = SampleNormal(random);
  return direction;
}

double Stiffness::Asymmetry() {
  RowMatrix direction = AsymmetryStart(solver_.model().num_dofs()), image;
  double radius = 0.0;
  for (int round = 0; round < kAsymmetryRounds; ++round) {
    image = RowMatrix::Zero(direction.rows(), 1);
    AddMultiply(solver_.wide_model().pattern, *negative_, direction, image);
    solver_.linear().Solve(image);  // −Ks⁻¹·K·d
    image += direction;
    radius = image.norm() / direction.norm();
    if (!(radius > 0.0)) return 0.0;
    direction = image / image.norm();
  }
  return radius;
}

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

EigenvalueGradient DeriveEigenvalue(StepSolver& solver, const MaterialField& material,
                                    const Eigen::VectorXd& x, const Eigen::VectorXd& shape) {
  constexpr double kMove = 1e-4;  // of the mean edge: differences err by its square and by rounding
  const ClothModel& model = solver.model();
  const double edge = std::sqrt(model.vertex_area.sum() / model.mesh.num_faces());
  const double move = kMove * edge / shape.cwiseAbs().maxCoeff();
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(x.size());
  RowMatrix by_x = RowMatrix::Zero(x.size(), 1);
  EigenvalueGradient gradient{.by_x = {}, .by_material = MaterialGradient::Zero(material, 1)};
  solver.Forget();
  for (const double side : {1.0, -1.0}) {
    const Eigen::VectorXd moved = x + side * move * shape;
    const RowMatrix weighed = -side / (2.0 * move) * shape;
    const BlockMatrix& negative = solver.StepDerivative(material, moved, still, 1.0);
    AddTransposeMultiply(solver.wide_model().pattern, negative, weighed, by_x);
    AddMaterialGradient(model, material, moved, still, 1.0, weighed, gradient.by_material);
  }
  gradient.by_x = by_x;
  return gradient;
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
