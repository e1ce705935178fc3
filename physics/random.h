// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <random>

namespace drape {

// Draws that follow from the seed alone on each platform, which std::normal_distribution and its
// like do not promise. (std::log and std::cos may differ in the last bit between C libraries.)

// In [0, 1), 53 random bits.
inline double DrawUniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Standard normal by Box and Muller (1958), the cosine branch; takes two numbers of the generator.
inline double DrawNormal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(1 - DrawUniform(random)));
  return radius * std::cos(2 * std::numbers::pi * DrawUniform(random));
}

}  // namespace drape
