// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/linalg/linear_solver.h"
#include "solver/studies/stability/steps/time_step.h"

namespace drape {
namespace {

// A·v = b, in place.
class System {
 public:
  virtual ~System() = default;
  virtual TimeStepStatus Solve(const BlockMatrix& A, Eigen::VectorXd& b) = 0;
  // What a state is between steps.
  virtual void Round(State&) const {}
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

class DirectSystem final : public System {
 public:
  explicit DirectSystem(const BlockPattern& pattern) : linear_(MakeLinearSolver(pattern)) {}
  TimeStepStatus Solve(const BlockMatrix& A, Eigen::VectorXd& b) override {
    if (!linear_->Factor(A)) return TimeStepStatus::kNotPositiveDefinite;
    linear_->Solve(b);
    return TimeStepStatus::kOk;
  }

 private:
  std::unique_ptr<LinearSolver> linear_;
};

class PcgSystem final : public System {
 public:
  PcgSystem(const BlockPattern& pattern, const PcgOptions& options) : pattern_(pattern) {
    pcg_.setTolerance(options.tolerance);
    pcg_.setMaxIterations(options.max_iterations);
  }
  TimeStepStatus Solve(const BlockMatrix& A, Eigen::VectorXd& b) override {
    const Eigen::SparseMatrix<double> sparse = ToSparse<double>(pattern_, A);
    pcg_.compute(sparse);
    if (pcg_.preconditioner().info() != Eigen::Success) return TimeStepStatus::kNotPositiveDefinite;
    b = pcg_.solve(b).eval();
    return pcg_.info() == Eigen::Success ? TimeStepStatus::kOk : TimeStepStatus::kNotConverged;
  }

 private:
  const BlockPattern& pattern_;
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper,
                           Eigen::IncompleteCholesky<double>>
      pcg_;
};

class FloatSystem final : public System {
 public:
  explicit FloatSystem(const BlockPattern& pattern) : pattern_(pattern) {}
  TimeStepStatus Solve(const BlockMatrix& A, Eigen::VectorXd& b) override {
    const Eigen::SparseMatrix<float> sparse = ToSparse<float>(pattern_, A);
    if (!analysed_) llt_.analyzePattern(sparse);
    analysed_ = true;
    llt_.factorize(sparse);
    if (llt_.info() != Eigen::Success) return TimeStepStatus::kNotPositiveDefinite;
    const Eigen::VectorXf rhs = b.cast<float>();
    b = llt_.solve(rhs).eval().cast<double>();
    return TimeStepStatus::kOk;
  }
  void Round(State& state) const override {
    state.x = state.x.cast<float>().cast<double>().eval();
    state.v = state.v.cast<float>().cast<double>().eval();
  }

 private:
  const BlockPattern& pattern_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<float>> llt_;
  bool analysed_ = false;
};

std::unique_ptr<System> MakeSystem(const BlockPattern& pattern, StepSystem system,
                                   const PcgOptions& pcg) {
  switch (system) {
    case StepSystem::kDirect:
      return std::make_unique<DirectSystem>(pattern);
    case StepSystem::kPcg:
      return std::make_unique<PcgSystem>(pattern, pcg);
    case StepSystem::kFloat:
      return std::make_unique<FloatSystem>(pattern);
  }
  LOG(FATAL) << "unknown StepSystem";
}

class OneSolveStep final : public TimeStep {
 public:
  OneSolveStep(std::shared_ptr<const ClothModel> model, const MaterialField& material, double h,
               StepSystem system, const PcgOptions& pcg)
      : model_(std::move(model)),
        material_(material),
        h_(h),
        mass_(model_->LumpedMass(material.density)),
        matrix_(model_->pattern),
        system_(MakeSystem(model_->pattern, system, pcg)) {
    CHECK_GT(h, 0.0);
  }

  TimeStepStatus Advance(State& state) override {
    system_->Round(state);
    AssembleStep(*model_, material_, state.x, h_, force_, matrix_);
    state.v = mass_.cwiseProduct(state.v) + h_ * force_;
    const TimeStepStatus status = system_->Solve(matrix_, state.v);
    if (!state.v.allFinite()) return TimeStepStatus::kNotFinite;
    state.x += h_ * state.v;
    system_->Round(state);
    return status;
  }

 private:
  std::shared_ptr<const ClothModel> model_;
  MaterialField material_;
  double h_;
  Eigen::VectorXd mass_, force_;
  BlockMatrix matrix_;
  std::unique_ptr<System> system_;
};

}  // namespace

std::unique_ptr<TimeStep> MakeOneSolveStep(std::shared_ptr<const ClothModel> model,
                                           const MaterialField& material, double h,
                                           StepSystem system, const PcgOptions& pcg) {
  return std::make_unique<OneSolveStep>(std::move(model), material, h, system, pcg);
}

}  // namespace drape
