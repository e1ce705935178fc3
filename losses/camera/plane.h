// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/math/host_device.h"

namespace drape {

// A point or vector of the image plane, for the host+device formulas of the losses [px].
struct Vec2 {
  double x, y;
};

DRAPE_INLINE Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.x + b.x, a.y + b.y}; }
DRAPE_INLINE Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.x - b.x, a.y - b.y}; }
DRAPE_INLINE Vec2 operator*(double s, const Vec2& a) { return {s * a.x, s * a.y}; }
DRAPE_INLINE bool operator==(const Vec2& a, const Vec2& b) { return a.x == b.x && a.y == b.y; }
DRAPE_INLINE double Dot(const Vec2& a, const Vec2& b) { return a.x * b.x + a.y * b.y; }
DRAPE_INLINE double Cross(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

// Column i of an array of shape [2, V].
DRAPE_INLINE Vec2 PointAt(const double* points, int i) {
  return {points[2 * i], points[2 * i + 1]};
}

}  // namespace drape
