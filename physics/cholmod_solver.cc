// SPDX-License-Identifier: Apache-2.0
#include <cholmod.h>
#include <glog/logging.h>
#include <omp.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "physics/blas.h"
#include "physics/linear_solver.h"
#include "physics/supernodal_factor.h"

namespace drape {
namespace {

// Lower triangle of the permuted matrix in compressed columns: where each stored number comes from
// in the block matrix. Permuted here once, CHOLMOD does not do it again in each factorisation.
struct LowerTriangle {
  std::vector<int> column_start, row, source;
};

// order[k]: the unknown that is eliminated as number k.
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

struct Analysis {
  std::vector<int> order;
  LowerTriangle lower;
};

// CHOLMOD opens parallel regions of four threads for each small supernode, whatever the machine
// (measured: half of the time in the kernel's scheduler). Within this scope they run on one thread.
class SerialScope {
 public:
  SerialScope() : levels_(omp_get_max_active_levels()) {
    omp_set_max_active_levels(omp_get_active_level());
  }
  SerialScope(const SerialScope&) = delete;
  SerialScope& operator=(const SerialScope&) = delete;
  ~SerialScope() { omp_set_max_active_levels(levels_); }

 private:
  int levels_;
};

class CholmodSolver final : public LinearSolver {
 public:
  explicit CholmodSolver(const BlockPattern& pattern) {
    Start();
    auto analysis = std::make_shared<Analysis>();
    analysis->order = EliminationOrder(pattern);
    analysis->lower = MakeLowerTriangle(pattern, analysis->order);
    analysis_ = std::move(analysis);
    MakeMatrix();
    factor_ = Analyze(matrix_, CHOLMOD_NATURAL, nullptr);
  }
  CholmodSolver(const CholmodSolver& other) : analysis_(other.analysis_) {
    Start();
    MakeMatrix();
    factor_ = cholmod_copy_factor(other.factor_, &common_);
    CHECK(factor_ != nullptr);
  }
  CholmodSolver& operator=(const CholmodSolver&) = delete;
  ~CholmodSolver() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_free_sparse(&matrix_, &common_);
    cholmod_free_dense(&x_, &common_);
    cholmod_free_dense(&y_, &common_);
    cholmod_free_dense(&e_, &common_);
    cholmod_finish(&common_);
  }

  std::unique_ptr<LinearSolver> Clone() const override {
    return std::make_unique<CholmodSolver>(*this);
  }

  bool Factor(const BlockMatrix& A) override {
    const SerialScope serial;
    double* value = static_cast<double*>(matrix_->x);
    const std::vector<int>& source = analysis_->lower.source;
    for (std::size_t k = 0; k < source.size(); ++k) value[k] = A.value[source[k]];
    cholmod_factorize(matrix_, factor_, &common_);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  void Solve(Eigen::VectorXd& b) override {
    const SerialScope serial;
    permuted_.resize(b.size(), 1);
    Permute(b, permuted_);
    cholmod_dense rhs{};
    rhs.nrow = rhs.d = rhs.nzmax = matrix_->nrow;
    rhs.ncol = 1;
    rhs.x = permuted_.data();
    rhs.xtype = CHOLMOD_REAL;
    rhs.dtype = CHOLMOD_DOUBLE;
    CHECK(cholmod_solve2(CHOLMOD_A, factor_, &rhs, nullptr, &x_, nullptr, &y_, &e_, &common_));
    Unpermute(Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(x_->x), b.size()), b);
  }

  void Solve(RowMatrix& b) override { SolveWith(static_cast<const double*>(factor_->x), b); }

  void SaveFactor(std::vector<double>& saved) const override {
    const double* x = static_cast<const double*>(factor_->x);
    saved.assign(x, x + factor_->xsize);
  }
  void SolveSaved(const std::vector<double>& saved, RowMatrix& b) override {
    CHECK_EQ(saved.size(), factor_->xsize);
    SolveWith(saved.data(), b);
  }
  std::size_t factor_bytes() const override { return factor_->xsize * sizeof(double); }

 private:
  void Start() {
    UseOneBlasThread();
    CHECK(cholmod_start(&common_));
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.quick_return_if_not_posdef = 1;
    common_.print = 0;  // "not positive definite" is a returned status
  }

  void MakeMatrix() { matrix_ = MakeSparse(analysis_->lower, CHOLMOD_REAL); }

  cholmod_sparse* MakeSparse(const LowerTriangle& lower, int xtype) {
    const std::size_t n = lower.column_start.size() - 1, nnz = lower.row.size();
    cholmod_sparse* matrix = cholmod_allocate_sparse(n, n, nnz, 1, 1, -1, xtype, &common_);
    CHECK(matrix != nullptr) << "CHOLMOD: out of memory";
    std::memcpy(matrix->p, lower.column_start.data(), (n + 1) * sizeof(int));
    std::memcpy(matrix->i, lower.row.data(), nnz * sizeof(int));
    return matrix;
  }

  // METIS on the vertices, not on the three times larger scalar graph: the three unknowns of a
  // vertex stay together and the analysis is faster.
  std::vector<int> VertexOrdering(const BlockPattern& p) {
    const int n = p.num_vertices();
    cholmod_sparse* graph =
        cholmod_allocate_sparse(n, n, p.num_blocks(), 1, 1, -1, CHOLMOD_PATTERN, &common_);
    CHECK(graph != nullptr);
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
    CHECK(cholmod_metis(graph, nullptr, 0, 1, order.data(), &common_));
    cholmod_free_sparse(&graph, &common_);
    return order;
  }

  cholmod_factor* Analyze(cholmod_sparse* matrix, int ordering, int* order) {
    common_.nmethods = 1;
    common_.method[0].ordering = ordering;
    common_.postorder = ordering != CHOLMOD_NATURAL;
    cholmod_factor* factor = cholmod_analyze_p(matrix, order, nullptr, 0, &common_);
    CHECK(factor != nullptr) << "CHOLMOD: out of memory in the symbolic analysis";
    return factor;
  }

  // Nested dissection of the vertices, then CHOLMOD's postorder of the elimination tree.
  std::vector<int> EliminationOrder(const BlockPattern& pattern) {
    std::vector<int> order, as_is(3 * pattern.num_vertices());
    for (int i : VertexOrdering(pattern))
      for (int k = 0; k < 3; ++k) order.push_back(3 * i + k);
    std::iota(as_is.begin(), as_is.end(), 0);
    cholmod_sparse* matrix = MakeSparse(MakeLowerTriangle(pattern, as_is), CHOLMOD_PATTERN);
    cholmod_factor* factor = Analyze(matrix, CHOLMOD_GIVEN, order.data());
    std::copy_n(static_cast<const int*>(factor->Perm), order.size(), order.begin());
    cholmod_free_factor(&factor, &common_);
    cholmod_free_sparse(&matrix, &common_);
    return order;
  }

  void SolveWith(const double* factor, RowMatrix& b) {
    const Eigen::Index m = b.cols(), padded = (m + 3) / 4 * 4;
    permuted_.resize(b.rows(), padded);
    for (Eigen::Index k = 0; k < b.rows(); ++k) {
      permuted_.row(k).head(m) = b.row(analysis_->order[k]);
      permuted_.row(k).tail(padded - m).setZero();
    }
    SolveRows(View(factor), permuted_);
    for (Eigen::Index k = 0; k < b.rows(); ++k)
      b.row(analysis_->order[k]) = permuted_.row(k).head(m);
  }

  void Permute(const auto& b, RowMatrix& permuted) const {
    for (Eigen::Index k = 0; k < b.rows(); ++k) permuted.row(k) = b.row(analysis_->order[k]);
  }
  void Unpermute(const auto& permuted, auto& b) const {
    for (Eigen::Index k = 0; k < b.rows(); ++k) b.row(analysis_->order[k]) = permuted.row(k);
  }

  SupernodalFactor View(const double* numbers) const {
    const auto ints = [](const void* p, std::size_t n) {
      return std::span(static_cast<const int*>(p), n);
    };
    return {ints(factor_->super, factor_->nsuper + 1), ints(factor_->pi, factor_->nsuper + 1),
            ints(factor_->px, factor_->nsuper + 1), ints(factor_->s, factor_->ssize),
            numbers};
  }

  std::shared_ptr<const Analysis> analysis_;
  cholmod_common common_{};
  cholmod_sparse* matrix_ = nullptr;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* x_ = nullptr;  // reused by the solves
  cholmod_dense* y_ = nullptr;
  cholmod_dense* e_ = nullptr;
  RowMatrix permuted_;
};

}  // namespace

std::unique_ptr<LinearSolver> MakeCholmodSolver(const BlockPattern& pattern) {
  return std::make_unique<CholmodSolver>(pattern);
}

}  // namespace drape
