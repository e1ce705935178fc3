// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/methods/projected_newton.h"

#include <Eigen/Eigenvalues>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/assembly/element_blocks.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {
namespace {

// The positive semidefinite part of the symmetric part of −Q.
template <int N>
void Project(double (&Q)[N][N]) {
  using Matrix = Eigen::Matrix<double, N, N, Eigen::RowMajor>;
  Eigen::Map<Matrix> map(&Q[0][0]);
  if (!map.allFinite()) return;
  const Matrix symmetric = -0.5 * (map + map.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(symmetric);
  const auto vectors = eigen.eigenvectors();
  map = vectors * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * vectors.transpose();
}

void AddFaces(const ClothModel& model, const MaterialField& material, const double* x,
              BlockMatrix& K) {
  const DeformationGradient<double> at_rest{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  std::visit(
      [&](const auto& law) {
        for (int f = 0; f < model.mesh.num_faces(); ++f) {
          const Face& face = model.mesh.faces[f];
          Matrix6 Q;
          StretchStepDerivative(law, GatherColumns(face, x), material.stretch_of(f), at_rest, 1.0,
                                Q);
          Project(Q);
          AddFaceBlocks(face, Q, face.area, &model.pattern.face_block[9 * f], K);
        }
      },
      model.law.stretch);
}

void AddHinges(const ClothModel& model, const MaterialField& material, const double* x,
               BlockMatrix& K) {
  const HingeCorners at_rest{};
  std::visit(
      [&](const auto& law) {
        for (int e = 0; e < model.mesh.num_hinges(); ++e) {
          const Hinge& hinge = model.mesh.hinges[e];
          double Q[12][12];
          BendStepDerivative(law, hinge, material.bend_of(e), GatherCorners(hinge, x), at_rest, 1.0,
                             Q);
          Project(Q);
          AddHingeBlocks(Q, &model.pattern.hinge_block[16 * e], K);
        }
      },
      model.law.bend);
}

class ProjectedSearch {
 public:
  ProjectedSearch(StepSolver& solver, const MaterialField& material,
                  const EquilibriumOptions& options, const Eigen::VectorXd& x)
      : solver_(solver),
        material_(material),
        K_(solver.model().pattern),
        weight_(CharacteristicForce(solver.model(), material)),
        here_(At(x)),
        best_(here_),
        control_(options, here_.residual, here_.energy) {}

  EquilibriumResult Run() {
    const double start_energy = here_.energy;
    EquilibriumStatus status = EquilibriumStatus::kNotConverged;
    NewtonNext next = control_.Next();
    for (; next == NewtonNext::kStep && Step(); next = control_.Next()) {
    }
    if (next == NewtonNext::kCancelled) status = EquilibriumStatus::kCancelled;
    if (next == NewtonNext::kConverged) status = control_.Conclude(AsymmetryHere());
    const Shape& end = next == NewtonNext::kConverged ? here_ : best_;
    return {.status = status,
            .x = end.x,
            .iterations = control_.iterations(),
            .factorisations = control_.factorisations(),
            .residual = end.residual,
            .start_energy = start_energy,
            .steps = control_.steps()};
  }

 private:
  struct Shape {
    Eigen::VectorXd x, force;
    double residual = 0.0, energy = 0.0;
  };

  Shape At(const Eigen::VectorXd& x) const {
    Shape at{.x = x, .force = {}};
    AssembleForce(solver_.model(), material_, x, at.force);
    at.residual = at.force.norm() / weight_;
    at.energy = Energy(solver_.model(), material_, x);
    return at;
  }

  // False when the projected K is singular.
  bool Step() {
    control_.FirstShift();
    AssembleProjectedStiffness(solver_.model(), material_, here_.x, K_);
    if (!solver_.linear().Factor(K_)) return false;
    Eigen::VectorXd dx = here_.force;
    solver_.linear().Solve(dx);
    here_ = At(here_.x + control_.Scale(dx.cwiseAbs().maxCoeff()) * dx);
    switch (control_.Judge(here_.residual, here_.energy)) {
      case NewtonVerdict::kNonMonotone:
        break;
      case NewtonVerdict::kAccept:
        best_ = here_;
        break;
      case NewtonVerdict::kRejectStep:
        here_ = best_;
        break;
    }
    return true;
  }

  std::optional<double> AsymmetryHere() {
    Stiffness stiffness(solver_, material_);
    stiffness.Assemble(here_.x);
    if (!stiffness.Factor()) return std::nullopt;
    return stiffness.Asymmetry();
  }

  StepSolver& solver_;
  const MaterialField& material_;
  BlockMatrix K_;
  double weight_;
  Shape here_, best_;  // the present shape; the last accepted one
  NewtonControl control_;
};

}  // namespace

void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K) {
  K.SetZero();
  if (model.scene.stretch) AddFaces(model, material, x.data(), K);
  if (model.scene.bend) AddHinges(model, material, x.data(), K);
  for (int i : model.held)
    K.AddScaledIdentity(model.pattern.diagonal[i], model.scene.handles->stiffness);
}

EquilibriumResult SolveEquilibriumProjected(StepSolver& solver, const MaterialField& material,
                                            const Eigen::VectorXd& x,
                                            const EquilibriumOptions& options) {
  return ProjectedSearch(solver, material, options, x).Run();
}

}  // namespace drape
