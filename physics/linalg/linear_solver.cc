// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/linear_solver.h"

#include <cholmod.h>
#include <glog/logging.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <new>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "physics/linalg/metis_lock.h"
#include "physics/linalg/supernodal_factor.h"

namespace drape {
namespace {

// The lower triangle of the permuted matrix, whose sources are places in the block matrix. order[k]
// is the unknown that is eliminated at position k.
LowerTriangle MakeLowerTriangle(const BlockPattern& p, const std::vector<int>& order) {
  std::vector<int> position(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) position[order[k]] = static_cast<int>(k);
  LowerTriangle lower;
  lower.column_start.push_back(0);
  std::vector<std::pair<int, int>> column;  // row, source
  for (int k = 0; k < static_cast<int>(order.size()); ++k) {
    const int j = order[k];
    column.clear();
    // Row j/3 of the symmetric pattern lists the row blocks of column j.
    for (int b = p.row_start[j / 3]; b < p.row_start[j / 3 + 1]; ++b)
      for (int i = 0; i < 3; ++i)
        if (const int row = position[3 * p.column[b] + i]; row >= k)
          column.emplace_back(row, 9 * b + 3 * (j % 3) + i);
    std::sort(column.begin(), column.end());
    for (const auto& [row, source] : column) {
      lower.row.push_back(row);
      lower.source.push_back(source);
    }
    lower.column_start.push_back(static_cast<int>(lower.row.size()));
  }
  return lower;
}

// The symbolic analysis by CHOLMOD.
class Analyser {
 public:
  Analyser() {
    CHECK(cholmod_start(&common_));
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.print = 0;
  }
  Analyser(const Analyser&) = delete;
  Analyser& operator=(const Analyser&) = delete;
  ~Analyser() { cholmod_finish(&common_); }

  // Nested dissection of the vertices, followed by CHOLMOD's postordering of the elimination tree.
  std::vector<int> EliminationOrder(const BlockPattern& pattern) {
    std::vector<int> order, as_is(3 * pattern.num_vertices());
    for (int i : VertexOrdering(pattern))
      for (int k = 0; k < 3; ++k) order.push_back(3 * i + k);
    std::iota(as_is.begin(), as_is.end(), 0);
    cholmod_factor* factor =
        Analyse(MakeLowerTriangle(pattern, as_is), CHOLMOD_GIVEN, order.data());
    std::copy_n(static_cast<const int*>(factor->Perm), order.size(), order.begin());
    cholmod_free_factor(&factor, &common_);
    return order;
  }

  SupernodalPattern BlockPatternFrom(const LowerTriangle& lower) {
    cholmod_factor* factor = Analyse(lower, CHOLMOD_NATURAL, nullptr);
    const auto ints = [](const void* p, std::size_t n) {
      return std::vector<int>(static_cast<const int*>(p), static_cast<const int*>(p) + n);
    };
    SupernodalPattern pattern{ints(factor->super, factor->nsuper + 1),
                              ints(factor->pi, factor->nsuper + 1),
                              ints(factor->px, factor->nsuper + 1), ints(factor->s, factor->ssize)};
    cholmod_free_factor(&factor, &common_);
    return pattern;
  }

 private:
  // METIS orders the vertices, not the scalar graph, which is three times larger: the three
  // unknowns of a vertex stay together, and the analysis is faster.
  std::vector<int> VertexOrdering(const BlockPattern& p) {
    const int n = p.num_vertices();
    cholmod_sparse* graph =
        cholmod_allocate_sparse(n, n, p.num_blocks(), 1, 1, -1, CHOLMOD_PATTERN, &common_);
    Require(graph != nullptr);
    int* start = static_cast<int*>(graph->p);
    int* row = static_cast<int*>(graph->i);
    int nnz = 0;
    for (int j = 0; j < n; ++j) {
      start[j] = nnz;
      for (int b = p.row_start[j]; b < p.row_start[j + 1]; ++b)
        if (p.column[b] >= j) row[nnz++] = p.column[b];
    }
    start[n] = nnz;
    std::vector<int> order(n);
    {
      const std::lock_guard guard(MetisLock());
      Require(cholmod_metis(graph, nullptr, 0, 1, order.data(), &common_) != 0);
    }
    cholmod_free_sparse(&graph, &common_);
    return order;
  }

  cholmod_factor* Analyse(const LowerTriangle& lower, int ordering, int* order) {
    const std::size_t n = lower.column_start.size() - 1, nnz = lower.row.size();
    cholmod_sparse* matrix =
        cholmod_allocate_sparse(n, n, nnz, 1, 1, -1, CHOLMOD_PATTERN, &common_);
    Require(matrix != nullptr);
    std::memcpy(matrix->p, lower.column_start.data(), (n + 1) * sizeof(int));
    std::memcpy(matrix->i, lower.row.data(), nnz * sizeof(int));
    common_.nmethods = 1;
    common_.method[0].ordering = ordering;
    common_.postorder = ordering != CHOLMOD_NATURAL;
    cholmod_factor* factor = cholmod_analyze_p(matrix, order, nullptr, 0, &common_);
    Require(factor != nullptr);
    cholmod_free_sparse(&matrix, &common_);
    return factor;
  }

  // What a mesh can be too large for, or the memory.
  void Require(bool succeeded) const {
    if (succeeded) return;
    if (common_.status == CHOLMOD_TOO_LARGE)
      throw std::runtime_error("the mesh is too large: its factor has more than 2^31 numbers");
    throw std::bad_alloc();
  }

  cholmod_common common_{};
};

// The results of the analysis, which runs once for each pattern.
struct Analysis {
  std::vector<int> order;  // of elimination: the k-th unknown
  SupernodalFactor factor;
};

Analysis Analyse(const BlockPattern& pattern) {
  Analyser analyser;
  std::vector<int> order = analyser.EliminationOrder(pattern);
  const LowerTriangle lower = MakeLowerTriangle(pattern, order);
  SupernodalFactor factor(analyser.BlockPatternFrom(lower), lower);
  return {std::move(order), std::move(factor)};
}

// Threads wait for one another for longer than they gain with fewer flops each, half a millisecond.
constexpr double kFlopsPerThread = 2e7;

class SupernodalSolver final : public LinearSolver {
 public:
  SupernodalSolver(const BlockPattern& pattern, int threads)
      : analysis_(std::make_shared<Analysis>(Analyse(pattern))) {
    SetThreads(threads);
  }

  std::unique_ptr<LinearSolver> Clone() const override {
    return std::make_unique<SupernodalSolver>(*this);
  }

  bool Factor(const BlockMatrix& A) override {
    if (cancelled()) return false;
    number_.resize(analysis_->factor.num_numbers());  // zero above the diagonals
    return analysis_->factor.Factor(A.value.data(), number_.data(), &workspace_, threads_, cancel_);
  }

  void Solve(Eigen::VectorXd& b) override {
    permuted_.resize(b.size(), 1);
    for (Eigen::Index k = 0; k < b.size(); ++k) permuted_(k, 0) = b[analysis_->order[k]];
    analysis_->factor.Solve(number_.data(), permuted_.data(), &workspace_, threads_);
    for (Eigen::Index k = 0; k < b.size(); ++k) b[analysis_->order[k]] = permuted_(k, 0);
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
    const double useful = factor_flops() / kFlopsPerThread;
    threads_ = useful < threads ? std::max(1, static_cast<int>(useful)) : threads;
  }

 private:
  void SolveWith(const std::vector<double>& number, RowMatrix& b) {
    const Eigen::Index m = b.cols(), padded = (m + 3) / 4 * 4;
    permuted_.resize(b.rows(), padded);
    for (Eigen::Index k = 0; k < b.rows(); ++k) {
      permuted_.row(k).head(m) = b.row(analysis_->order[k]);
      permuted_.row(k).tail(padded - m).setZero();
    }
    analysis_->factor.SolveRows(number.data(), permuted_, threads_);
    for (Eigen::Index k = 0; k < b.rows(); ++k)
      b.row(analysis_->order[k]) = permuted_.row(k).head(m);
  }

  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> number_;
  FactorWorkspace workspace_;
  int threads_ = 1;
  RowMatrix permuted_;
};

}  // namespace

std::unique_ptr<LinearSolver> MakeLinearSolver(const BlockPattern& pattern, int threads) {
  return std::make_unique<SupernodalSolver>(pattern, threads);
}

}  // namespace drape
