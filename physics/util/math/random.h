// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace drape {

// Random numbers that depend on the seed alone, on every platform, which std::normal_distribution
// and its relatives do not guarantee. (std::log and std::cos may differ in the last bit between C
// libraries.)

// Returns the seed of stream number `stream`: output number `stream` of SplitMix64 [Steele 2014]
// started at `seed`, so that all streams of one seed get unrelated seeds.
inline uint64_t SeedOfStream(uint64_t seed, uint64_t stream) {
  uint64_t z = seed + (stream + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

// A uniform number in [0, 1) with 53 random bits.
inline double SampleUniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// A standard normal number by the cosine branch of the Box–Muller transform [Box 1958]. It consumes
// two numbers of the generator.
inline double SampleNormal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(1 - SampleUniform(random)));
  return radius * std::cos(2 * std::numbers::pi * SampleUniform(random));
}

}  // namespace drape
