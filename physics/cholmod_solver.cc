// SPDX-License-Identifier: Apache-2.0
#include <cholmod.h>
#include <glog/logging.h>
#include <omp.h>

#include <cstring>

#include "physics/blas.h"
#include "physics/linear_solver.h"

namespace drape {
namespace {

// Lower triangle in compressed columns: where each stored number comes from in the block matrix.
struct LowerTriangle {
  std::vector<int> column_start, row, source;
};

LowerTriangle MakeLowerTriangle(const BlockPattern& p) {
  LowerTriangle lower;
  lower.column_start.push_back(0);
  for (int j = 0; j < 3 * p.num_vertices(); ++j) {
    // Row j/3 of the symmetric pattern lists the row blocks of column j.
    for (int b = p.row_start[j / 3]; b < p.row_start[j / 3 + 1]; ++b)
      for (int k = 0; k < 3; ++k) {
        const int i = 3 * p.column[b] + k;
        if (i < j) continue;
        lower.row.push_back(i);
        lower.source.push_back(9 * b + 3 * (j % 3) + k);
      }
    lower.column_start.push_back(static_cast<int>(lower.row.size()));
  }
  return lower;
}

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
  explicit CholmodSolver(const BlockPattern& pattern)
      : lower_(std::make_shared<LowerTriangle>(MakeLowerTriangle(pattern))) {
    Start(3 * pattern.num_vertices());
    Analyze(pattern);
  }
  CholmodSolver(const CholmodSolver& other) : lower_(other.lower_) {
    Start(static_cast<int>(other.matrix_->nrow));
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
    for (std::size_t k = 0; k < lower_->source.size(); ++k) value[k] = A.value[lower_->source[k]];
    cholmod_factorize(matrix_, factor_, &common_);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  void Solve(Eigen::VectorXd& b) override { SolveColumns(b.data(), 1, b.data()); }

  void Solve(RowMatrix& b) override {
    columns_ = b;
    SolveColumns(columns_.data(), static_cast<int>(b.cols()), columns_.data());
    b = columns_;
  }

  std::vector<double> SaveFactor() const override {
    const double* x = static_cast<const double*>(factor_->x);
    return std::vector<double>(x, x + factor_->xsize);
  }
  void LoadFactor(const std::vector<double>& saved) override {
    CHECK_EQ(saved.size(), factor_->xsize);
    std::memcpy(factor_->x, saved.data(), factor_bytes());
  }
  std::size_t factor_bytes() const override { return factor_->xsize * sizeof(double); }

 private:
  void Start(int n) {
    UseOneBlasThread();
    CHECK(cholmod_start(&common_));
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.quick_return_if_not_posdef = 1;
    common_.print = 0;  // "not positive definite" is a returned status
    const int nnz = static_cast<int>(lower_->row.size());
    matrix_ = cholmod_allocate_sparse(n, n, nnz, 1, 1, -1, CHOLMOD_REAL, &common_);
    CHECK(matrix_ != nullptr);
    std::memcpy(matrix_->p, lower_->column_start.data(), (n + 1) * sizeof(int));
    std::memcpy(matrix_->i, lower_->row.data(), nnz * sizeof(int));
  }

  // METIS on the vertices, not on the three times larger scalar graph: the three unknowns of a
  // vertex stay together and the analysis is faster.
  std::vector<int> VertexOrdering(const BlockPattern& p) {
    const int n = p.num_vertices();
    cholmod_sparse* graph = cholmod_allocate_sparse(n, n, p.num_blocks(), 1, 1, -1, CHOLMOD_PATTERN, &common_);
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

  void Analyze(const BlockPattern& pattern) {
    std::vector<int> order;
    for (int i : VertexOrdering(pattern))
      for (int k = 0; k < 3; ++k) order.push_back(3 * i + k);
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
    factor_ = cholmod_analyze_p(matrix_, order.data(), nullptr, 0, &common_);
    CHECK(factor_ != nullptr) << "CHOLMOD: out of memory in the symbolic analysis";
  }

  void SolveColumns(double* b, int count, double* x) {
    const SerialScope serial;
    cholmod_dense rhs{};
    rhs.nrow = rhs.d = matrix_->nrow;
    rhs.ncol = count;
    rhs.nzmax = rhs.nrow * count;
    rhs.x = b;
    rhs.xtype = CHOLMOD_REAL;
    rhs.dtype = CHOLMOD_DOUBLE;
    CHECK(cholmod_solve2(CHOLMOD_A, factor_, &rhs, nullptr, &x_, nullptr, &y_, &e_, &common_));
    std::memcpy(x, x_->x, rhs.nzmax * sizeof(double));
  }

  std::shared_ptr<const LowerTriangle> lower_;
  cholmod_common common_{};
  cholmod_sparse* matrix_ = nullptr;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* x_ = nullptr;  // reused by the solves
  cholmod_dense* y_ = nullptr;
  cholmod_dense* e_ = nullptr;
  Eigen::MatrixXd columns_;
};

}  // namespace

std::unique_ptr<LinearSolver> MakeCholmodSolver(const BlockPattern& pattern) {
  return std::make_unique<CholmodSolver>(pattern);
}

}  // namespace drape
