// SPDX-License-Identifier: Apache-2.0
#include "physics/stiffness.h"

#include <algorithm>
#include <limits>
#include <random>
#include <utility>

#include "physics/random.h"

namespace drape {
namespace {

// ½(K + Kᵀ) of a stiffness given as −K.
void Symmetrise(const BlockPattern& pattern, const BlockMatrix& negative, BlockMatrix& K) {
  for (int i = 0; i < pattern.num_vertices(); ++i)
    for (int b = pattern.row_start[i]; b < pattern.row_start[i + 1]; ++b) {
      const int j = pattern.column[b];
      const auto begin = pattern.column.begin();
      const int mirror = static_cast<int>(
          std::lower_bound(begin + pattern.row_start[j], begin + pattern.row_start[j + 1], i) -
          begin);
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

}  // namespace

Stiffness::Stiffness(StepSolver& solver, const MaterialField& material)
    : solver_(solver), material_(material), symmetric_(solver.model().pattern) {}

void Stiffness::Assemble(const Eigen::VectorXd& x) {
  negative_ = &solver_.StepDerivative(material_, x, Eigen::VectorXd::Zero(x.size()), 1.0);
  Symmetrise(solver_.model().pattern, *negative_, symmetric_);
}

void Stiffness::AddStress(const StressField& change) {
  AddGeometricStiffness(solver_.model(), change, symmetric_);
}

bool Stiffness::Factor() { return solver_.linear().Factor(symmetric_); }

bool Stiffness::FactorShifted(const StiffnessShift& shift, double* mu, int* tries) {
  const auto add = [&](double more) {
    if (more > 0.0) AddShift(solver_.model(), material_.density, more, shift.length, symmetric_);
  };
  add(*mu);
  for (;;) {
    if (tries != nullptr) ++*tries;
    if (Factor()) return true;
    const double next = std::max(4.0 * *mu, shift.first);
    if (next > shift.most) return false;
    add(next - *mu);
    *mu = next;
  }
}

bool Stiffness::Solve(const RowMatrix& rhs, RowMatrix* solution) {
  return SolveWith(AddMultiply, rhs, solution);
}
bool Stiffness::SolveTransposed(const RowMatrix& rhs, RowMatrix* solution) {
  return SolveWith(AddTransposeMultiply, rhs, solution);
}

// multiply: the product of −K that goes with the system.
bool Stiffness::SolveWith(decltype(AddMultiply)& multiply, const RowMatrix& rhs,
                          RowMatrix* solution) {
  constexpr int kMaxRounds = 40;
  constexpr double kTolerance = 1e-10, kRoundingAtMost = 1e-6, kStandsStill = 0.9;
  constexpr double kSmallest = std::numeric_limits<double>::min();  // columns of zeros
  const Eigen::RowVectorXd size_of_rhs = rhs.colwise().norm().cwiseMax(kSmallest);
  const auto relative = [&](const RowMatrix& r) {
    return r.colwise().norm().cwiseQuotient(size_of_rhs).maxCoeff();
  };
  double size = 1.0;
  RowMatrix residual = rhs, step;
  RowMatrix before = RowMatrix::Zero(rhs.rows(), rhs.cols());
  *solution = before;
  Eigen::RowVectorXd weight, square, last_square;
  for (int round = 0; round < kMaxRounds; ++round) {
    step = residual;
    solver_.linear().Solve(step);
    square = residual.cwiseProduct(step).colwise().sum();
    weight = round == 0
                 ? Eigen::RowVectorXd::Ones(rhs.cols()).eval()
                 : (1.0 / (1.0 + square.array() / last_square.array() / weight.array())).matrix();
    weight = (square.array() > 0.0).select(weight, 1.0);  // columns of zeros
    last_square = square;
    step += *solution - before;
    before += step * weight.asDiagonal();
    before.swap(*solution);
    residual = rhs;
    multiply(solver_.model().pattern, *negative_, *solution, residual);
    const double size_before = std::exchange(size, relative(residual));
    if (size <= kTolerance || (size <= kRoundingAtMost && size > kStandsStill * size_before))
      return true;
  }
  return false;
}

double Stiffness::Asymmetry() {
  constexpr int kRounds = 8;
  std::mt19937_64 random(1);
  RowMatrix direction(solver_.model().num_dofs(), 1), image;
  for (Eigen::Index i = 0; i < direction.rows(); ++i) direction(i, 0) = DrawNormal(random);
  double radius = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    image = RowMatrix::Zero(direction.rows(), 1);
    AddMultiply(solver_.model().pattern, *negative_, direction, image);
    solver_.linear().Solve(image);  // −Ks⁻¹·K·d
    image += direction;
    radius = image.norm() / direction.norm();
    if (!(radius > 0.0)) return 0.0;
    direction = image / image.norm();
  }
  return radius;
}

}  // namespace drape
