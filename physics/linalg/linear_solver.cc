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

  void Solve(Eigen::VectorXd& b) override { SolveColumn(number_, b.data(), b.size()); }

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
  void SolveColumn(const std::vector<double>& number, double* b, Eigen::Index size) {
    permuted_.resize(size, 1);
    for (Eigen::Index k = 0; k < size; ++k) permuted_(k, 0) = b[Unknown(k)];
    analysis_->factor.Solve(number.data(), permuted_.data(), &workspace_, threads_);
    for (Eigen::Index k = 0; k < size; ++k) b[Unknown(k)] = permuted_(k, 0);
  }
  void SolveWith(const std::vector<double>& number, RowMatrix& b) {
    if (b.cols() == 1) return SolveColumn(number, b.data(), b.size());
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

constexpr int kMaxRounds = 40;
constexpr double kTolerance = 1e-9, kRoundingAtMost = 1e-6, kStagnation = 0.9;

template <class T>
void Compact(const std::vector<int>& positions, std::vector<T>& values) {
  for (std::size_t i = 0; i < positions.size(); ++i) values[i] = values[positions[i]];
  values.resize(positions.size());
}

}  // namespace

std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern, int threads) {
  return std::make_unique<SupernodalSolver>(pattern, DissectVertices(pattern), threads);
}

CgwRecurrence::CgwRecurrence(std::span<const double> rhs_norm)
    : rhs_norm_(rhs_norm.begin(), rhs_norm.end()),
      square_(rhs_norm.size()),
      weight_(rhs_norm.size()) {
  std::vector<int> nonzero;
  for (int c = 0; c < static_cast<int>(rhs_norm.size()); ++c) {
    active_.push_back(c);
    if (rhs_norm[c] != 0.0) nonzero.push_back(c);
  }
  Keep(nonzero);
}

std::span<const double> CgwRecurrence::Weights(std::span<const double> square) {
  CHECK_EQ(square.size(), active_.size());
  for (std::size_t i = 0; i < square.size(); ++i) {
    const double before = std::exchange(square_[i], square[i]);
    const bool underflow = !(square[i] > 0.0);
    weight_[i] = round_ == 0 || underflow ? 1.0 : 1.0 / (1.0 + square[i] / before / weight_[i]);
  }
  return weight_;
}

void CgwRecurrence::Judge(std::span<const double> residual_norm) {
  CHECK_EQ(residual_norm.size(), active_.size());
  const double worst_before = std::exchange(worst_, 0.0);
  std::vector<int> unsolved;
  for (std::size_t i = 0; i < residual_norm.size(); ++i) {
    const double relative = residual_norm[i] / rhs_norm_[i];
    if (!(relative <= kTolerance)) unsolved.push_back(static_cast<int>(i));
    if (!(relative <= worst_)) worst_ = relative;  // also when `relative` is NaN
  }
  if (worst_ <= kRoundingAtMost && worst_ > kStagnation * worst_before) unsolved.clear();
  Keep(unsolved);
  if (++round_ == kMaxRounds && status_ == CgwStatus::kGoOn) status_ = CgwStatus::kGaveUp;
}

void CgwRecurrence::Keep(const std::vector<int>& positions) {
  kept_ = positions;
  Compact(positions, active_);
  Compact(positions, rhs_norm_);
  Compact(positions, square_);
  Compact(positions, weight_);
  if (active_.empty()) status_ = CgwStatus::kSolved;
}

}  // namespace drape
