// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "physics/mesh/disc.h"
#include "solver/forward/drape_pool.h"

namespace drape {

// A pool of simulated drapes as far as a fit starts from it [METHODS, P76]: the numbers of their
// specimens and their outlines.
struct OutlinePool {
  std::string mesh, setting;  // as DrapePool
  DrapeDiscs discs;
  uint64_t seed = 0;
  double scale = 1.0;                    // of its lengths, over those of NumberRanges
  std::vector<SpecimenNumbers> numbers;  // to 1/65535 of their ranges
  std::vector<Eigen::VectorXd> radius;   // [m], shape [kPoolAngles]; to kPackedRadius

  int num_drapes() const { return static_cast<int>(numbers.size()); }
};
inline constexpr double kPackedRadius = 2e-5;  // [m]

// The bytes of a file of some 130 bytes for each drape: one line of JSON, then 16-bit numbers
// compressed by zlib. Unpacking throws InputError (prefix `where`) for bytes that are not such a
// file or are damaged.
std::string PackPool(const OutlinePool& pool);
OutlinePool UnpackPool(std::string_view bytes, const std::string& where);

// The files that are compiled in (solver/forward/pools).
std::vector<std::string_view> ListBuiltInPools();
// The one of discs of this ratio, to .1 %, at their size: a drape of a cloth that is s times as
// large is s times as large itself where its bending length and stretching over weight are. nullptr
// where there is none. Unpacked and scaled once. For any thread.
const OutlinePool* FindBuiltInPool(const DrapeDiscs& discs);

// A drape of a pool that is like an outline, turned and mirrored as suits it best.
struct PooledMatch {
  int drape = 0;            // in the pool
  double distance = 0.0;    // root mean square of the outlines' difference [m]
  SpecimenNumbers numbers;  // of the turned cloth; its start's as in the pool
};
// The nearest drapes to an outline [m], shape [kPoolAngles], at most `count`, nearest first; each
// at all kPoolAngles rotations and in both mirror images.
std::vector<PooledMatch> FindNearest(const OutlinePool& pool, const Eigen::VectorXd& radius,
                                     int count);

// The bending length [m] of the drapes of a pool that are like an outline: the median and the ends
// of the 90 % interval of the nearest ones, weighed by their distance [Beaumont 2002].
struct PooledLength {
  double low = 0.0, median = 0.0, high = 0.0;
  bool reaches_least = false, reaches_most = false;  // an end of the range of the pool
  double distance = 0.0;                             // of the nearest, as PooledMatch
};
PooledLength EstimateBendingLength(const OutlinePool& pool, const Eigen::VectorXd& radius);

// The numbers of a cloth turned counter-clockwise by an angle [rad]: ln of bend is interpolated
// between the directions by its waves 0, 2 and 4, stretch by its wave 2; what a turn makes unequal
// at +45° and −45° is averaged, as the tables have one number for both.
SpecimenNumbers TurnedNumbers(const SpecimenNumbers& numbers, double angle);

}  // namespace drape
