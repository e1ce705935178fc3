// SPDX-License-Identifier: Apache-2.0
#include "physics/supernodal_factor.h"

// Of the BLAS that CHOLMOD uses (Fortran names: every BLAS has them).
extern "C" {
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
void dgemm_(const char* trans_a, const char* trans_b, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
}

namespace drape {
namespace {

// One supernode: its triangle and the rows below it, in one column-major panel.
struct Supernode {
  int column, width, stride, below;
  const double* triangle;
  const int* row_below;

  const double* rectangle() const { return triangle + width; }
};

Supernode GetSupernode(const SupernodalFactor& f, int s) {
  const int width = f.first_column[s + 1] - f.first_column[s];
  const int rows = f.first_row[s + 1] - f.first_row[s];
  return {f.first_column[s], width, rows, rows - width, f.number + f.first_number[s],
          f.row.data() + f.first_row[s] + width};
}

// To the BLAS the row-major b is the column-major bᵀ, so all products come from the right.
// bᵀ ← bᵀ·L⁻ᵀ (forward) or bᵀ·L⁻¹ (backward), own rows only.
void SolveTriangle(const Supernode& node, const char* trans, int m, double* own) {
  const double one = 1.0;
  dtrsm_("R", "L", trans, "N", &m, &node.width, &one, node.triangle, &node.stride, own, &m);
}

}  // namespace

void SolveRows(const SupernodalFactor& factor, RowMatrix& b, RowMatrix& workspace) {
  const int supernodes = static_cast<int>(factor.first_column.size()) - 1;
  const int m = static_cast<int>(b.cols());
  const double one = 1.0, zero = 0.0, minus_one = -1.0;
  workspace.resize(b.rows(), b.cols());
  for (int s = 0; s < supernodes; ++s) {  // L·y = b
    const Supernode node = GetSupernode(factor, s);
    double* own = b.row(node.column).data();
    SolveTriangle(node, "T", m, own);
    if (node.below == 0) continue;
    dgemm_("N", "T", &m, &node.below, &node.width, &one, own, &m, node.rectangle(), &node.stride,
           &zero, workspace.data(), &m);
    for (int i = 0; i < node.below; ++i) b.row(node.row_below[i]) -= workspace.row(i);
  }
  for (int s = supernodes - 1; s >= 0; --s) {  // Lᵀ·x = y
    const Supernode node = GetSupernode(factor, s);
    double* own = b.row(node.column).data();
    for (int i = 0; i < node.below; ++i) workspace.row(i) = b.row(node.row_below[i]);
    if (node.below > 0)
      dgemm_("N", "N", &m, &node.width, &node.below, &minus_one, workspace.data(), &m,
             node.rectangle(), &node.stride, &one, own, &m);
    SolveTriangle(node, "N", m, own);
  }
}

}  // namespace drape
