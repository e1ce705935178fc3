// SPDX-License-Identifier: Apache-2.0
#pragma once

// Warp-wide tiles of double matrices on the tensor cores. A lane is 4g + t, g = 0..7, t = 0..3.

namespace drape {

struct Lane {
  int g, t;
};
__device__ __forceinline__ Lane LaneOfWarp() {
  const int lane = static_cast<int>(threadIdx.x & 31);
  return {lane >> 2, lane & 3};
}

// d += A·B for A [16, 8] and B [8, 8] in fragments:
//   a = {(g, t), (g + 8, t), (g, t + 4), (g + 8, t + 4)},  b = {(t, g), (t + 4, g)},
//   d = {(g, 2t), (g, 2t + 1), (g + 8, 2t), (g + 8, 2t + 1)}.
// Any order of the eight summands serves as long as a and b agree on it.
__device__ __forceinline__ void MultiplyAdd(double (&d)[4], const double (&a)[4],
                                            const double (&b)[2]) {
#if __CUDA_ARCH__ >= 900
  asm volatile(
      "mma.sync.aligned.m16n8k8.row.col.f64.f64.f64.f64 {%0,%1,%2,%3},{%4,%5,%6,%7},{%8,%9},"
      "{%0,%1,%2,%3};"
      : "+d"(d[0]), "+d"(d[1]), "+d"(d[2]), "+d"(d[3])
      : "d"(a[0]), "d"(a[1]), "d"(a[2]), "d"(a[3]), "d"(b[0]), "d"(b[1]));
#else
  // The tile of compute capability 8.0: [8, 4]·[4, 8].
  for (int half = 0; half < 2; ++half)
    for (int k = 0; k < 2; ++k)
      asm volatile("mma.sync.aligned.m8n8k4.row.col.f64.f64.f64.f64 {%0,%1},{%2},{%3},{%0,%1};"
                   : "+d"(d[2 * half]), "+d"(d[2 * half + 1])
                   : "d"(a[half + 2 * k]), "d"(b[k]));
#endif
}

// Fragment of rows 0..15 (or `rows` 8: the upper half twice) of a row-major matrix, eight columns.
__device__ __forceinline__ void LoadA(double (&a)[4], const double* at, int stride, Lane lane,
                                      int upper = 8) {
  const double *low = at + lane.g * stride + lane.t, *high = low + upper * stride;
  a[0] = low[0];
  a[1] = high[0];
  a[2] = low[4];
  a[3] = high[4];
}
// B = the transpose of eight rows of a row-major matrix.
__device__ __forceinline__ void LoadTransposedB(double (&b)[2], const double* at, int stride,
                                                Lane lane) {
  b[0] = at[lane.g * stride + lane.t];
  b[1] = at[lane.g * stride + lane.t + 4];
}

__device__ __forceinline__ double Shuffle(double value, int from) {
  return __shfl_sync(0xffffffffu, value, from);
}
__device__ __forceinline__ double ShuffleXor(double value, int mask) {
  return __shfl_xor_sync(0xffffffffu, value, mask);
}

// 1/x to rounding by a third-order step from the approximate instruction.
__device__ __forceinline__ double Reciprocal(double x) {
  double r;
  asm("rcp.approx.ftz.f64 %0,%1;" : "=d"(r) : "d"(x));
  double error = fma(-x, r, 1.0);
  error = fma(error, error, error);
  return fma(r, error, r);
}

// 1/√x in the same way.
__device__ __forceinline__ double ReciprocalRoot(double x) {
  double r;
  asm("rsqrt.approx.ftz.f64 %0,%1;" : "=d"(r) : "d"(x));
  const double error = fma(-x * r, r, 1.0);
  return fma(r * error, fma(error, 0.375, 0.5), r);
}

// Inverse of the Cholesky factor of an 8×8 matrix, both in the layout of d[0..1]: (a0, a1) → (e0,
// e1). False (in all lanes) when a pivot is not positive.
__device__ __forceinline__ bool InvertCholesky8(double a0, double a1, double& e0, double& e1,
                                                Lane lane) {
  const int g = lane.g, t = lane.t;
  e0 = g == 2 * t ? 1.0 : 0.0;
  e1 = g == 2 * t + 1 ? 1.0 : 0.0;
  double own_pivot = 1.0;
  bool positive = true;
#pragma unroll
  for (int k = 0; k < 8; ++k) {
    const double column = (k & 1) ? a1 : a0;
    const double pivot = Shuffle(column, 4 * k + (k >> 1));
    const double below = Shuffle(column, 4 * g + (k >> 1));
    const double right0 = Shuffle(column, 8 * t + (k >> 1));
    const double right1 = Shuffle(column, 8 * t + 4 + (k >> 1));
    const double row0 = Shuffle(e0, 4 * k + t), row1 = Shuffle(e1, 4 * k + t);
    positive = positive && pivot > 0.0;
    const double factor = g > k ? -below * Reciprocal(pivot) : 0.0;
    if (g == k) own_pivot = pivot;
    if (2 * t > k) a0 = fma(factor, right0, a0);
    if (2 * t + 1 > k) a1 = fma(factor, right1, a1);
    e0 = fma(factor, row0, e0);
    e1 = fma(factor, row1, e1);
  }
  const double scale = ReciprocalRoot(own_pivot);
  e0 *= scale;
  e1 *= scale;
  return positive;
}

}  // namespace drape
