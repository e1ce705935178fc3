// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace drape {

// Draws that follow from the seed alone on each platform, which std::normal_distribution and its
// like do not promise. (std::log and std::cos may differ in the last bit between C libraries.)

// A seed for each stream of one seed, far from those of the others: SplitMix64
// [Steele 2014], output number `stream`.
inline uint64_t SeedOfStream(uint64_t seed, uint64_t stream) {
  uint64_t z = seed + (stream + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

// In [0, 1), 53 random bits.
inline double SampleUniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Standard normal [Box 1958], the cosine branch; takes two numbers of the generator.
inline double SampleNormal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(1 - SampleUniform(random)));
  return radius * std::cos(2 * std::numbers::pi * SampleUniform(random));
}

}  // namespace drape
