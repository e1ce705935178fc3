// SPDX-License-Identifier: Apache-2.0
#include "physics/simulation/statics/stiffness.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "physics/linalg/cgw_recurrence.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

// ½(K + Kᵀ) of a stiffness given as −K.
void Symmetrise(const BlockPattern& pattern, const BlockMatrix& negative, int threads,
                BlockMatrix& K) {
#pragma omp parallel for num_threads(threads) if (threads > 1)
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const int j = pattern.column[b];
      const int mirror = pattern.Find(j, i);
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

}  // namespace

Stiffness::Stiffness(StepSolver& solver, const MaterialField& material)
    : solver_(solver),
      material_(material),
      weightless_(material),
      symmetric_(solver.wide_model().pattern) {
  weightless_.density = 0.0;
}

void Stiffness::Assemble(const Eigen::VectorXd& x, StiffnessPart part) {
  negative_ = &solver_.StepDerivative(material_, x, Eigen::VectorXd::Zero(x.size()), 1.0);
  const BlockPattern& pattern = solver_.wide_model().pattern;
  if (symmetric_.value.size() != negative_->value.size()) symmetric_ = BlockMatrix(pattern);
  Symmetrise(pattern, *negative_, solver_.threads(), symmetric_);
  if (part == StiffnessPart::kWhole || solver_.self_contact() == nullptr) return;
  ForEachPairStiffness(
      solver_.self_contact()->FindActivePairs(x), StiffnessPart::kNegative,
      [&](int i, int j, const Eigen::Matrix3d& block) { CHECK(AddBlock(i, j, -block)); });
}

void Stiffness::AssemblePositive(const Eigen::VectorXd& x) {
  const BlockPattern& pattern = solver_.wide_model().pattern;
  if (symmetric_.value.size() != 9 * pattern.column.size()) symmetric_ = BlockMatrix(pattern);
  Eigen::VectorXd force;
  AssembleStep(solver_.wide_model(), weightless_, x, 1.0, force, symmetric_, solver_.self_contact(),
               solver_.parts());
}

void Stiffness::AddStress(const StressField& change) {
  AddGeometricStiffness(solver_.wide_model(), change, symmetric_);
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

}  // namespace drape
