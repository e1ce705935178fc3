// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/linalg/blocks/block_matrix.h"
#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"
#include "physics/mesh/mesh.h"
#include "physics/util/math/simd.h"

namespace drape {

// The small matrices of elements, added to a block matrix: the rows of the corners whose bit of
// `corners` is set.

// The nine numbers of a 3×3 block, row-major, in vector registers.
struct BlockNumbers {
  Vec4 first, second;
  double last;
};
DRAPE_INLINE BlockNumbers operator+(const BlockNumbers& a, const BlockNumbers& b) {
  return {a.first + b.first, a.second + b.second, a.last + b.last};
}
DRAPE_INLINE BlockNumbers operator*(const BlockNumbers& a, const BlockNumbers& b) {
  return {a.first * b.first, a.second * b.second, a.last * b.last};
}
DRAPE_INLINE BlockNumbers operator*(double s, const BlockNumbers& a) {
  return {s * a.first, s * a.second, s * a.last};
}
// The factors of an outer product a·bᵀ, spread over its nine numbers.
DRAPE_INLINE BlockNumbers AsRows(const Vec3<double>& a) {
  return {Vec4{a.x, a.x, a.x, a.y}, Vec4{a.y, a.y, a.z, a.z}, a.z};
}
DRAPE_INLINE BlockNumbers AsColumns(const Vec3<double>& b) {
  return {Vec4{b.x, b.y, b.z, b.x}, Vec4{b.y, b.z, b.x, b.y}, b.z};
}
DRAPE_INLINE BlockNumbers ScaledIdentity(double s) {
  return {Vec4{s, 0, 0, 0}, Vec4{s, 0, 0, 0}, s};
}

DRAPE_INLINE void AddBlock(const BlockNumbers& block, double* out) {
  Store(LoadAs<Vec4>(out) + block.first, out);
  Store(LoadAs<Vec4>(out + 4) + block.second, out + 4);
  out[8] += block.last;
}

using Matrix6 = double[6][6];  // over the columns of F, as StretchStepDerivative orders them

// Adds scale·[Du Dv]ᵀ·Q·[Du Dv] to the nine blocks of a face.
inline void AddFaceBlocks(const Face& face, const Matrix6& Q, double scale, const int* blocks,
                          BlockMatrix& A, unsigned corners = ~0U) {
  const ShapeGradient s = GradientOf(face);
  const auto part = [&](int i, int k) {  // of Q: uu uv, vu vv
    const auto row = [&](int r) { return Q[3 * i + r] + 3 * k; };
    const double *x = row(0), *y = row(1), *z = row(2);
    return scale * BlockNumbers{Vec4{x[0], x[1], x[2], y[0]}, Vec4{y[1], y[2], z[0], z[1]}, z[2]};
  };
  const BlockNumbers uu = part(0, 0), uv = part(0, 1), vu = part(1, 0), vv = part(1, 1);
  for (int a = 0; a < 3; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    const BlockNumbers u = s.u[a] * uu + s.v[a] * vu, v = s.u[a] * uv + s.v[a] * vv;
    for (int b = 0; b < 3; ++b) AddBlock(s.u[b] * u + s.v[b] * v, A.block(blocks[3 * a + b]));
  }
}

// Adds scale·∫(∂G:C:∂G + S:∂²G) to the nine blocks of a face with the columns F of its deformation.
inline void AddFaceBlocks(const Face& face, const DeformationGradient<double>& F,
                          const SymmetricStretch& C, const StretchStress<double>& S, double scale,
                          const int* blocks, BlockMatrix& A, unsigned corners = ~0U) {
  const ShapeGradient s = GradientOf(face);
  const BlockNumbers u = AsRows(F.u), v = AsRows(F.v), ut = AsColumns(F.u), vt = AsColumns(F.v);
  const BlockNumbers uu = u * ut, uv = u * vt, vu = v * ut, vv = v * vt;
  for (int a = 0; a < 3; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    const double ua = scale * s.u[a], va = scale * s.v[a];
    for (int b = 0; b < 3; ++b) {
      const double ub = s.u[b], vb = s.v[b], both = ua * vb + va * ub;
      const double at_u = ua * ub, at_v = va * vb, at_uv = ua * vb, at_vu = va * ub;
      AddBlock((at_u * C.uu_uu + both * C.uu_uv + at_v * C.uv_uv) * uu +
                   (at_u * C.uu_uv + at_uv * C.uu_vv + at_vu * C.uv_uv + at_v * C.vv_uv) * uv +
                   (at_u * C.uu_uv + at_uv * C.uv_uv + at_vu * C.uu_vv + at_v * C.vv_uv) * vu +
                   (at_u * C.uv_uv + both * C.vv_uv + at_v * C.vv_vv) * vv +
                   ScaledIdentity(GeometricWeight(S, ua, va, ub, vb)),
               A.block(blocks[3 * a + b]));
    }
  }
}

inline void AddHingeBlocks(const double (&Q)[12][12], const int* blocks, BlockMatrix& A) {
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      double* out = A.block(blocks[4 * a + b]);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) out[3 * i + k] += Q[3 * a + i][3 * b + k];
    }
}

// Adds scale·d·dᵀ to the sixteen blocks of a hinge.
inline void AddHingeBlocks(const HingeGradient& gradient, double scale, const int* blocks,
                           BlockMatrix& A, unsigned corners = ~0U) {
  BlockNumbers column[4];
  for (int b = 0; b < 4; ++b) column[b] = AsColumns(gradient.d[b]);
  for (int a = 0; a < 4; ++a) {
    if ((corners >> a & 1U) == 0) continue;
    const BlockNumbers row = AsRows(scale * gradient.d[a]);
    for (int b = 0; b < 4; ++b) AddBlock(row * column[b], A.block(blocks[4 * a + b]));
  }
}

// Adds scale·∂g/∂x of a hinge to its sixteen blocks, as AddBendStepBlocks does block by block.
inline void AddHingeBlocks(const BendStepRates& rates, double scale, const int* blocks,
                           BlockMatrix& A, unsigned corners = ~0U) {
  // −s·∂²θ: of a wing, between its apex, the edge's end n1 and both; n0 follows from zero sums.
  struct Wing {
    BlockNumbers apex, apex_n1, n1_apex, n1;
  } wing[2];
  const double moment = -scale * rates.s;
  for (int side = 0; side < 2; ++side) {
    const WingRates& r = rates.hessian.wing[side];
    const BlockNumbers m = AsRows(r.m), p = AsRows(r.height), ta = AsRows(r.t_by_a);
    const BlockNumbers mt = AsColumns(r.m), pt = AsColumns(r.height), tat = AsColumns(r.t_by_a),
                       tet = AsColumns(r.t_by_e);
    const auto entry = [&](auto part) {
      return WingRateEntry(r.inverse_h2, r.t, part(p), part(m), part(ta), part(pt), part(mt),
                           part(tat), part(tet));
    };
    const auto first = entry([](const BlockNumbers& n) { return n.first; });
    const auto second = entry([](const BlockNumbers& n) { return n.second; });
    const auto last = entry([](const BlockNumbers& n) { return n.last; });
    wing[side] = {moment * BlockNumbers{first.m_by_a, second.m_by_a, last.m_by_a},
                  moment * BlockNumbers{first.m_by_e, second.m_by_e, last.m_by_e},
                  moment * BlockNumbers{first.n1_by_a, second.n1_by_a, last.n1_by_a},
                  moment * BlockNumbers{first.n1_by_e, second.n1_by_e, last.n1_by_e}};
  }
  const Wing &w0 = wing[0], &w1 = wing[1];
  const BlockNumbers n1 = w0.n1 + w1.n1, n1_apex = w0.n1_apex + w1.n1_apex;
  const BlockNumbers apex_n1 = w0.apex_n1 + w1.apex_n1;
  BlockNumbers column[4];
  for (int b = 0; b < 4; ++b) column[b] = AsColumns(rates.grad_s.d[b]);
  const auto add = [&](int a, const BlockNumbers& b0, const BlockNumbers& b1,
                       const BlockNumbers& b2, const BlockNumbers& b3) {
    if ((corners >> a & 1U) == 0) return;
    const BlockNumbers row = AsRows(-scale * rates.grad.d[a]);
    AddBlock(row * column[0] + b0, A.block(blocks[4 * a]));
    AddBlock(row * column[1] + b1, A.block(blocks[4 * a + 1]));
    AddBlock(row * column[2] + b2, A.block(blocks[4 * a + 2]));
    AddBlock(row * column[3] + b3, A.block(blocks[4 * a + 3]));
  };
  const BlockNumbers kZero{};
  const BlockNumbers to_apex0 = w0.apex + w0.n1_apex, to_apex1 = w1.apex + w1.n1_apex;
  const BlockNumbers to_n1 = apex_n1 + n1;
  add(0, to_apex0 + to_apex1 + to_n1, -1.0 * to_n1, -1.0 * to_apex0, -1.0 * to_apex1);
  add(1, -1.0 * (n1_apex + n1), n1, w0.n1_apex, w1.n1_apex);
  add(2, -1.0 * (w0.apex + w0.apex_n1), w0.apex_n1, w0.apex, kZero);
  add(3, -1.0 * (w1.apex + w1.apex_n1), w1.apex_n1, kZero, w1.apex);
}

}  // namespace drape
