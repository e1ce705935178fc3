// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {

// Adds the small matrices of elements to a block matrix, for the loops of assembly: the rows of the
// corners whose bit is set.

using Matrix6 = double[6][6];  // over the columns of F, as StretchStepDerivative orders them

// The block is contiguous and comes from a local array without aliases, which makes two or three
// vector instructions.
inline void AddBlock(const double (&block)[9], double* out) {
  for (int i = 0; i < 9; ++i) out[i] += block[i];
}

// Adds scale·[Du Dv]ᵀ·Q·[Du Dv] to the nine blocks of a face.
inline void AddFaceBlocks(const Face& face, const Matrix6& Q, double scale, const int* blocks,
                          BlockMatrix& A, unsigned corners = ~0U) {
  const ShapeGradient s = GradientOf(face);
  double part[2][2][9];  // Q's blocks uu uv, vu vv
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) part[i / 3][k / 3][3 * (i % 3) + k % 3] = scale * Q[i][k];
  for (int a = 0; a < 3; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    double row_u[9], row_v[9];
    for (int i = 0; i < 9; ++i) {
      row_u[i] = s.u[a] * part[0][0][i] + s.v[a] * part[1][0][i];
      row_v[i] = s.u[a] * part[0][1][i] + s.v[a] * part[1][1][i];
    }
    for (int b = 0; b < 3; ++b) {
      double block[9];
      for (int i = 0; i < 9; ++i) block[i] = s.u[b] * row_u[i] + s.v[b] * row_v[i];
      AddBlock(block, A.block(blocks[3 * a + b]));
    }
  }
}

inline void AddHingeBlocks(const double (&Q)[12][12], const int* blocks, BlockMatrix& A,
                           unsigned corners = ~0U) {
  for (int a = 0; a < 4; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    for (int b = 0; b < 4; ++b) {
      double block[9];
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) block[3 * i + k] = Q[3 * a + i][3 * b + k];
      AddBlock(block, A.block(blocks[4 * a + b]));
    }
  }
}

// Adds scale·d·dᵀ to the sixteen blocks of a hinge.
inline void AddHingeBlocks(const HingeGradient& gradient, double scale, const int* blocks,
                           BlockMatrix& A, unsigned corners = ~0U) {
  for (int a = 0; a < 4; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    const Vec3<double> row = scale * gradient.d[a];
    for (int b = 0; b < 4; ++b) {
      const Vec3<double>& d = gradient.d[b];
      AddBlock({row.x * d.x, row.x * d.y, row.x * d.z, row.y * d.x, row.y * d.y, row.y * d.z,
                row.z * d.x, row.z * d.y, row.z * d.z},
               A.block(blocks[4 * a + b]));
    }
  }
}

}  // namespace drape
