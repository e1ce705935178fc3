// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

// DRAPE_HD marks the pure functions that both the CPU loops and the CUDA kernels call. DRAPE_INLINE
// marks those that compile to a few instructions, because g++ does not inline them in the element
// loops (measured: derivatives take twice as long).
#ifdef __CUDACC__
#define DRAPE_HD __host__ __device__
#define DRAPE_INLINE __host__ __device__ __forceinline__
#else
#define DRAPE_HD
#define DRAPE_INLINE inline __attribute__((always_inline))
#endif

namespace drape {

// A 3-vector of any scalar (double, float, Dual) for the host+device element kernels.
template <class T>
struct Vec3 {
  T x, y, z;
};

template <class T>
DRAPE_INLINE Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
DRAPE_INLINE Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S, class T>
DRAPE_INLINE Vec3<T> operator*(const S& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
// A vector of doubles scaled by another scalar type (a fixed direction times a dual coefficient).
template <class T>
DRAPE_INLINE Vec3<T> Scale(const T& s, const Vec3<double>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T, class U>
DRAPE_INLINE T Dot(const Vec3<T>& a, const Vec3<U>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
DRAPE_INLINE Vec3<T> Cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Reads vertex `i` of a node-major array, writes it, or adds to it.
DRAPE_INLINE Vec3<double> LoadVec3(const double* nodes, int i) {
  return {nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2]};
}
DRAPE_INLINE void StoreVec3(double* nodes, int i, const Vec3<double>& a) {
  nodes[3 * i] = a.x;
  nodes[3 * i + 1] = a.y;
  nodes[3 * i + 2] = a.z;
}
DRAPE_INLINE void AddTo(double* nodes, int i, const Vec3<double>& a) {
  nodes[3 * i] += a.x;
  nodes[3 * i + 1] += a.y;
  nodes[3 * i + 2] += a.z;
}

// A forward-mode dual number with the value `a` and N derivatives `v`, for host and device
// (ceres::Jet is host only).
template <int N>
struct Dual {
  double a = 0.0;
  double v[N] = {};

  Dual() = default;
  DRAPE_INLINE Dual(double value) : a(value) {}  // NOLINT(google-explicit-constructor): a constant
  DRAPE_INLINE Dual(double value, int seed) : a(value) { v[seed] = 1.0; }

  DRAPE_INLINE Dual& operator+=(const Dual& o) { return *this = *this + o; }
  DRAPE_INLINE Dual operator-() const { return Chain(*this, -a, -1.0); }

  // f(x), given its value and its derivative at x.a.
  DRAPE_INLINE static Dual Chain(const Dual& x, double value, double derivative) {
    Dual r(value);
    for (int i = 0; i < N; ++i) r.v[i] = derivative * x.v[i];
    return r;
  }
  // f(x, y), given its value and its two partial derivatives.
  DRAPE_INLINE static Dual Chain(const Dual& x, double dx, const Dual& y, double dy, double value) {
    Dual r(value);
    for (int i = 0; i < N; ++i) r.v[i] = dx * x.v[i] + dy * y.v[i];
    return r;
  }

  friend DRAPE_INLINE Dual operator+(const Dual& x, const Dual& y) {
    return Chain(x, 1.0, y, 1.0, x.a + y.a);
  }
  friend DRAPE_INLINE Dual operator-(const Dual& x, const Dual& y) {
    return Chain(x, 1.0, y, -1.0, x.a - y.a);
  }
  friend DRAPE_INLINE Dual operator*(const Dual& x, const Dual& y) {
    return Chain(x, y.a, y, x.a, x.a * y.a);
  }
  friend DRAPE_INLINE Dual operator/(const Dual& x, const Dual& y) {
    const double inverse = 1.0 / y.a, value = x.a * inverse;
    return Chain(x, inverse, y, -value * inverse, value);
  }
  friend DRAPE_INLINE Dual operator+(const Dual& x, double s) { return Chain(x, x.a + s, 1.0); }
  friend DRAPE_INLINE Dual operator+(double s, const Dual& x) { return x + s; }
  friend DRAPE_INLINE Dual operator-(const Dual& x, double s) { return x + (-s); }
  friend DRAPE_INLINE Dual operator-(double s, const Dual& x) { return Chain(x, s - x.a, -1.0); }
  friend DRAPE_INLINE Dual operator*(const Dual& x, double s) { return Chain(x, x.a * s, s); }
  friend DRAPE_INLINE Dual operator*(double s, const Dual& x) { return x * s; }
  friend DRAPE_INLINE Dual operator/(const Dual& x, double s) { return x * (1.0 / s); }
  friend DRAPE_INLINE Dual operator/(double s, const Dual& x) { return Dual(s) / x; }
};

template <int N>
DRAPE_INLINE Dual<N> sqrt(const Dual<N>& x) {
  const double root = ::sqrt(x.a);
  return Dual<N>::Chain(x, root, 0.5 / root);
}
template <int N>
DRAPE_INLINE Dual<N> sin(const Dual<N>& x) {
  return Dual<N>::Chain(x, ::sin(x.a), ::cos(x.a));
}
template <int N>
DRAPE_INLINE Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double inverse = 1.0 / (x.a * x.a + y.a * y.a);
  return Dual<N>::Chain(y, x.a * inverse, x, -y.a * inverse, ::atan2(y.a, x.a));
}

// The plain value of a scalar, for comparisons that select a branch of a formula.
DRAPE_INLINE double Value(double x) { return x; }
DRAPE_INLINE double Value(float x) { return x; }
template <int N>
DRAPE_INLINE double Value(const Dual<N>& x) {
  return x.a;
}
template <class T>
DRAPE_INLINE T Abs(const T& x) {
  return Value(x) < 0.0 ? -x : x;
}

}  // namespace drape
