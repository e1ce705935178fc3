// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_methods.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/linalg/linear_solver.h"
#include "physics/simulation/rollout.h"

namespace drape {
namespace {

// A linear solver of which a step uses no more than Factor and Solve of a vector.
class StudySolver : public LinearSolver {
 public:
  std::unique_ptr<LinearSolver> Clone() const override { LOG(FATAL) << "not cloned"; }
  std::unique_ptr<LinearSolver> Adapt(const BlockPattern&) const override {
    LOG(FATAL) << "no contact of the cloth with itself";
  }
  void Solve(RowMatrix&) override { LOG(FATAL) << "one right-hand side only"; }
  void SaveFactor(std::vector<double>&) const override { LOG(FATAL) << "no adjoint"; }
  void SolveSaved(const std::vector<double>&, RowMatrix&) override { LOG(FATAL) << "no adjoint"; }
  std::size_t factor_bytes() const override { return 0; }
};

// The whole of a symmetric matrix; rows of the pattern are its columns.
template <class T>
Eigen::SparseMatrix<T> ToSparse(const BlockPattern& p, const BlockMatrix& A) {
  const int n = 3 * p.num_vertices();
  Eigen::SparseMatrix<T> sparse(n, n);
  sparse.reserve(9 * p.num_blocks());
  for (int j = 0; j < n; ++j) {
    sparse.startVec(j);
    for (int b = p.row_start[j / 3]; b < p.row_start[j / 3 + 1]; ++b)
      for (int k = 0; k < 3; ++k)
        sparse.insertBack(3 * p.column[b] + k, j) = static_cast<T>(A.block(b)[3 * (j % 3) + k]);
  }
  sparse.finalize();
  return sparse;
}

class PcgSolver final : public StudySolver {
 public:
  PcgSolver(const BlockPattern& pattern, const PcgOptions& options) : pattern_(pattern) {
    pcg_.setTolerance(options.tolerance);
    pcg_.setMaxIterations(options.max_iterations);
  }
  bool Factor(const BlockMatrix& A) override {
    sparse_ = ToSparse<double>(pattern_, A);
    pcg_.compute(sparse_);
    return pcg_.preconditioner().info() == Eigen::Success;
  }
  void Solve(Eigen::VectorXd& b) override { b = pcg_.solve(b).eval(); }
  bool converged() const { return pcg_.info() == Eigen::Success; }

 private:
  const BlockPattern& pattern_;
  Eigen::SparseMatrix<double> sparse_;
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                           Eigen::IncompleteCholesky<double>>
      pcg_;
};

class FloatSolver final : public StudySolver {
 public:
  explicit FloatSolver(const BlockPattern& pattern) : pattern_(pattern) {}
  bool Factor(const BlockMatrix& A) override {
    const Eigen::SparseMatrix<float> sparse = ToSparse<float>(pattern_, A);
    if (!analysed_) llt_.analyzePattern(sparse);
    analysed_ = true;
    llt_.factorize(sparse);
    return llt_.info() == Eigen::Success;
  }
  void Solve(Eigen::VectorXd& b) override {
    const Eigen::VectorXf rhs = b.cast<float>();
    b = llt_.solve(rhs).eval().cast<double>();
  }

 private:
  const BlockPattern& pattern_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<float>> llt_;
  bool analysed_ = false;
};

// The step of production with this linear solver.
Integrator MakeOneSolveStep(const std::shared_ptr<const ClothModel>& model,
                            const MaterialField& material, double h,
                            std::unique_ptr<LinearSolver> linear) {
  CHECK_GT(h, 0.0);
  const auto solver = std::make_shared<StepSolver>(model, std::move(linear));
  const Eigen::VectorXd mass = model->LumpedMass(material.density);
  return [=](State& state) {
    switch (AdvanceOneStep(*solver, material, mass, h, state)) {
      case RolloutStatus::kNotPositiveDefinite:
        return solver->force().allFinite() ? IntegratorStatus::kNotPositiveDefinite
                                           : IntegratorStatus::kNotFinite;
      case RolloutStatus::kNotFinite:
        return IntegratorStatus::kNotFinite;
      default:
        return IntegratorStatus::kOk;
    }
  };
}

void RoundToFloat(State& state) {
  state.x = state.x.cast<float>().cast<double>().eval();
  state.v = state.v.cast<float>().cast<double>().eval();
}

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

}  // namespace

Integrator MakeExplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h, double drag) {
  CHECK_GT(h, 0.0);
  CHECK_GE(drag, 0.0);
  const double slowing = 1.0 / (1.0 + h * drag);
  const Eigen::VectorXd inverse_mass = model->LumpedMass(material.density).cwiseInverse();
  return [=, force = Eigen::VectorXd()](State& state) mutable {
    AssembleForce(*model, material, state.x, force);
    state.v = slowing * (state.v + h * inverse_mass.cwiseProduct(force));
    state.x += h * state.v;
    return state.x.allFinite() ? IntegratorStatus::kOk : IntegratorStatus::kNotFinite;
  };
}

Integrator MakeLinearlyImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                                     const MaterialField& material, double h,
                                     StepLinearSolver solver, const PcgOptions& pcg) {
  const BlockPattern& pattern = model->pattern;
  if (solver == StepLinearSolver::kPcg) {
    auto linear = std::make_unique<PcgSolver>(pattern, pcg);
    const PcgSolver& gradients = *linear;  // the step keeps it
    return
        [step = MakeOneSolveStep(model, material, h, std::move(linear)), &gradients](State& state) {
          const IntegratorStatus status = step(state);
          const bool is_solved = status != IntegratorStatus::kOk || gradients.converged();
          return is_solved ? status : IntegratorStatus::kNotConverged;
        };
  }
  if (solver == StepLinearSolver::kFloat)
    return [step = MakeOneSolveStep(model, material, h, std::make_unique<FloatSolver>(pattern))](
               State& state) {
      RoundToFloat(state);
      const IntegratorStatus status = step(state);
      RoundToFloat(state);
      return status;
    };
  return MakeOneSolveStep(model, material, h, MakeLinearSolver(pattern));
}

Integrator MakeImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                             const MaterialField& material, double h,
                             const ImplicitEulerOptions& options) {
  const auto euler = std::make_shared<ImplicitEuler>(model, material, h, options);
  return [euler](State& state) { return euler->Advance(state); };
}

void AssembleProjectedStiffness(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, BlockMatrix& K) {
  K.SetZero();
  if (model.scene.stretch) AddFaces(model, material, x.data(), K);
  if (model.scene.bend) AddHinges(model, material, x.data(), K);
  for (int i : model.held)
    K.AddScaledIdentity(model.pattern.diagonal[i], model.scene.handles->stiffness);
}

}  // namespace drape
