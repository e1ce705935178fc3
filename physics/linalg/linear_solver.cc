// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/linear_solver.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "physics/linalg/supernodal_factor.h"
#include "physics/linalg/symbolic_analysis.h"

namespace drape {
namespace {

// The results of the analysis, which runs once for each pattern.
struct Analysis {
  Analysis(const BlockPattern& pattern_in, const EliminationOrder& order_in)
      : Analysis(pattern_in, order_in, AnalyseSymbolically(pattern_in, order_in.vertex)) {}

  BlockPattern pattern;
  EliminationOrder order;
  SupernodalFactor factor;

 private:
  Analysis(const BlockPattern& pattern_in, const EliminationOrder& order_in,
           SymbolicAnalysis symbolic)
      : pattern(pattern_in), order(order_in), factor(std::move(symbolic.pattern), symbolic.lower) {}
};

// Threads wait for one another for longer than they gain with fewer flops each, half a millisecond.
constexpr double kFlopsPerThread = 2e7;

class SupernodalSolver final : public LinearSolver {
 public:
  SupernodalSolver(const BlockPattern& pattern, const EliminationOrder& order, int threads)
      : analysis_(std::make_shared<Analysis>(pattern, order)) {
    SetThreads(threads);
  }

  std::unique_ptr<LinearSolver> Clone() const override {
    return std::make_unique<SupernodalSolver>(*this);
  }

  std::unique_ptr<LinearSolver> Adapt(const BlockPattern& other) const override {
    return std::make_unique<SupernodalSolver>(
        other, AdaptOrder(analysis_->order, analysis_->pattern, other), asked_threads_);
  }

  bool Factor(const BlockMatrix& A) override {
    if (cancelled()) return false;
    number_.resize(analysis_->factor.num_numbers());  // zero above the diagonals
    return analysis_->factor.Factor(A.value.data(), number_.data(), &workspace_, threads_, cancel_);
  }

  void Solve(Eigen::VectorXd& b) override {
    permuted_.resize(b.size(), 1);
    for (Eigen::Index k = 0; k < b.size(); ++k) permuted_(k, 0) = b[Unknown(k)];
    analysis_->factor.Solve(number_.data(), permuted_.data(), &workspace_, threads_);
    for (Eigen::Index k = 0; k < b.size(); ++k) b[Unknown(k)] = permuted_(k, 0);
  }

  void Solve(RowMatrix& b) override { SolveWith(number_, b); }

  void SaveFactor(std::vector<double>& saved) const override { saved = number_; }
  void SolveSaved(const std::vector<double>& saved, RowMatrix& b) override {
    CHECK_EQ(saved.size(), analysis_->factor.num_numbers());
    SolveWith(saved, b);
  }
  std::size_t factor_bytes() const override {
    return analysis_->factor.num_numbers() * sizeof(double);
  }
  double factor_flops() const override { return analysis_->factor.flops(); }
  void SetThreads(int threads) override {
    CHECK_GE(threads, 1);
    asked_threads_ = threads;
    const double useful = factor_flops() / kFlopsPerThread;
    threads_ = useful < threads ? std::max(1, static_cast<int>(useful)) : threads;
  }

 private:
  void SolveWith(const std::vector<double>& number, RowMatrix& b) {
    const Eigen::Index m = b.cols(), padded = (m + 3) / 4 * 4;
    permuted_.resize(b.rows(), padded);
    for (Eigen::Index k = 0; k < b.rows(); ++k) {
      permuted_.row(k).head(m) = b.row(Unknown(k));
      permuted_.row(k).tail(padded - m).setZero();
    }
    analysis_->factor.SolveRows(number.data(), permuted_, threads_);
    for (Eigen::Index k = 0; k < b.rows(); ++k) b.row(Unknown(k)) = permuted_.row(k).head(m);
  }
  // The unknown that is eliminated at place k.
  Eigen::Index Unknown(Eigen::Index k) const { return 3 * analysis_->order.vertex[k / 3] + k % 3; }

  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> number_;
  FactorWorkspace workspace_;
  int asked_threads_ = 1, threads_ = 1;
  RowMatrix permuted_;
};

}  // namespace

std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern, int threads) {
  return std::make_unique<SupernodalSolver>(pattern, DissectVertices(pattern), threads);
}

}  // namespace drape
