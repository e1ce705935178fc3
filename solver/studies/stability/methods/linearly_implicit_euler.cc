// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <memory>
#include <utility>
#include <vector>

#include "physics/linalg/linear_solver.h"
#include "physics/simulation/rollout.h"
#include "solver/studies/stability/methods/integrator.h"

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

// The step of production; subclasses exchange its linear solver.
class LinearlyImplicitEuler : public Integrator {
 public:
  LinearlyImplicitEuler(const std::shared_ptr<const ClothModel>& model,
                        const MaterialField& material, double h,
                        std::unique_ptr<LinearSolver> linear)
      : material_(material),
        h_(h),
        mass_(model->LumpedMass(material.density)),
        solver_(model, std::move(linear)) {
    CHECK_GT(h, 0.0);
  }

  IntegratorStatus Advance(State& state) override {
    switch (AdvanceOneStep(solver_, material_, mass_, h_, state)) {
      case RolloutStatus::kNotPositiveDefinite:
        return solver_.force().allFinite() ? IntegratorStatus::kNotPositiveDefinite
                                           : IntegratorStatus::kNotFinite;
      case RolloutStatus::kNotFinite:
        return IntegratorStatus::kNotFinite;
      default:
        return IntegratorStatus::kOk;
    }
  }

 protected:
  LinearSolver& linear() { return solver_.linear(); }

 private:
  MaterialField material_;
  double h_;
  Eigen::VectorXd mass_;
  StepSolver solver_;
};

class IterativeStep final : public LinearlyImplicitEuler {
 public:
  using LinearlyImplicitEuler::LinearlyImplicitEuler;
  IntegratorStatus Advance(State& state) override {
    const IntegratorStatus status = LinearlyImplicitEuler::Advance(state);
    const bool converged = static_cast<const PcgSolver&>(linear()).converged();
    return status == IntegratorStatus::kOk && !converged ? IntegratorStatus::kNotConverged : status;
  }
};

class FloatStep final : public LinearlyImplicitEuler {
 public:
  using LinearlyImplicitEuler::LinearlyImplicitEuler;
  IntegratorStatus Advance(State& state) override {
    Round(state);
    const IntegratorStatus status = LinearlyImplicitEuler::Advance(state);
    Round(state);
    return status;
  }

 private:
  static void Round(State& state) {
    state.x = state.x.cast<float>().cast<double>().eval();
    state.v = state.v.cast<float>().cast<double>().eval();
  }
};

}  // namespace

std::unique_ptr<Integrator> MakeLinearlyImplicitEuler(std::shared_ptr<const ClothModel> model,
                                                      const MaterialField& material, double h,
                                                      StepLinearSolver solver,
                                                      const PcgOptions& pcg) {
  const BlockPattern& pattern = model->pattern;
  switch (solver) {
    case StepLinearSolver::kDirect:
      return std::make_unique<LinearlyImplicitEuler>(model, material, h, MakeLinearSolver(pattern));
    case StepLinearSolver::kPcg:
      return std::make_unique<IterativeStep>(model, material, h,
                                             std::make_unique<PcgSolver>(pattern, pcg));
    case StepLinearSolver::kFloat:
      return std::make_unique<FloatStep>(model, material, h,
                                         std::make_unique<FloatSolver>(pattern));
  }
  LOG(FATAL) << "unknown StepLinearSolver";
}

}  // namespace drape
