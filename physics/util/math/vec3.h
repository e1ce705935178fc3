// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/math/host_device.h"

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

// Reads vertex `i` of a node-major array, or adds to it.
DRAPE_INLINE Vec3<double> LoadVec3(const double* nodes, int i) {
  return {nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2]};
}
DRAPE_INLINE void AddTo(double* nodes, int i, const Vec3<double>& a) {
  nodes[3 * i] += a.x;
  nodes[3 * i + 1] += a.y;
  nodes[3 * i + 2] += a.z;
}

}  // namespace drape
