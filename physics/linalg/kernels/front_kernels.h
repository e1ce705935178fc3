// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace drape {

// The rows and columns that a front passes to its parent: the lower triangle of a square matrix of
// `size` columns, by blocks of eight columns. A block holds its rows from its first column on,
// padded to a multiple of eight, column by column.
struct UpdateMatrix {
  double* number;
  int size;

  static constexpr int kBlock = 8;
  static int Padded(int size) { return (size + kBlock - 1) / kBlock * kBlock; }
  static std::size_t NumNumbers(int size) {
    const std::size_t padded = Padded(size);
    return padded * (padded + kBlock) / 2;
  }

  // The distance between two columns of the column's block.
  int stride(int column) const { return Padded(size) - column / kBlock * kBlock; }
  // A pointer p for which p[i] is the number in row i ≥ j of column j.
  double* column(int j) const {
    const std::ptrdiff_t block = j / kBlock, padded = Padded(size);
    return number + kBlock * block * padded - kBlock * kBlock / 2 * block * (block - 1) +
           (j % kBlock) * stride(j) - kBlock * block;
  }
};

// Own columns of a front, column-major: rows of the front, padded with zeros to a multiple of
// eight (`stride`).
struct FrontPanel {
  double* number;
  int stride, rows, width;

  double* column(int j) const { return number + static_cast<std::ptrdiff_t>(j) * stride; }
};

// Rows from … from + length of a matrix become rows to … to + length of another.
struct RowRun {
  int from, to, length;
};

// The loops in which a factorisation spends its time, compiled for one vector width each. All
// versions sum each number in the same order: their results are equal bit for bit.
struct FrontKernels {
  const char* name;

  // Factors the own columns begin … end, from which all earlier ones are subtracted, L·Lᵀ = A in
  // these rows, and solves for the rows below. begin: a multiple of eight. Numbers above the
  // diagonal are not kept. Returns false when A is not positive definite.
  bool (*factor_columns)(const FrontPanel& panel, int begin, int end);
  // Subtracts the products of the columns begin … end, multiples of eight, from the own columns
  // first … last, which come after them.
  void (*subtract_columns)(const FrontPanel& panel, int begin, int end, int first, int last);
  // Computes −B·Bᵀ of the rows below of a factored panel, in the columns begin … end of the
  // product. begin: a multiple of eight.
  void (*multiply_below)(const FrontPanel& panel, const UpdateMatrix& product, int begin, int end);
  // Adds the columns first … first + count of a child's matrix to columns of its parent: from[n] is
  // row 0 of column first + n and to[n] that of the column to which it is added, `runs` to `end`
  // say the rows. All these columns are rows of the first run.
  void (*add_columns)(const double* const* from, double* const* to, int first, int count,
                      const RowRun* runs, const RowRun* end);

  // For measurements: as many multiply-adds as the registers hold, `rounds` times, and their sum.
  double (*multiply_add)(long rounds, double factor);
  int flops_per_round;
};

// The versions that this build has and this machine can run, narrowest first.
const std::vector<const FrontKernels*>& AvailableFrontKernels();
// The widest of them, or the one that the environment variable DRAPE_VECTORS names.
const FrontKernels& ChosenFrontKernels();

// Defined in front_kernels_avx512.cc, where the build has it (DRAPE_AVX512_KERNELS).
extern const FrontKernels kAvx512FrontKernels;

}  // namespace drape
