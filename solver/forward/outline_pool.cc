// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/outline_pool.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "losses/outline/measured_image.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

constexpr char kPackedFormat[] = "drapefit-outline-pool";
constexpr int kPackedVersion = 1;
constexpr double kMostCount = 65535.0;
constexpr int kColumns = kSpecimenNumbers + kPoolAngles;
constexpr int kMostDrapes = 1 << 16;  // of a file

using Counts = Eigen::Array<uint16_t, Eigen::Dynamic, kColumns>;  // by columns, which packs better

double FromCount(const NumberRange& range, double count) {
  return range.low + (range.high - range.low) * count / kMostCount;
}

OutlinePool Scaled(OutlinePool pool, double scale) {
  pool.discs = {.specimen = scale * pool.discs.specimen, .support = scale * pool.discs.support};
  pool.scale *= scale;
  for (SpecimenNumbers& numbers : pool.numbers)
    for (const int length : {kLogBendingLength, kLogStretchLength, kLogStartHeight})
      numbers[length] += std::log(scale);
  for (Eigen::VectorXd& radius : pool.radius) radius *= scale;
  return pool;
}

uint16_t ToCount(const NumberRange& range, double value) {
  const double share = (value - range.low) / (range.high - range.low);
  return static_cast<uint16_t>(std::lround(kMostCount * std::clamp(share, 0.0, 1.0)));
}

}  // namespace

std::string PackPool(const OutlinePool& pool) {
  Counts counts(pool.num_drapes(), kColumns);
  for (int i = 0; i < pool.num_drapes(); ++i) {
    for (int k = 0; k < kSpecimenNumbers; ++k)
      counts(i, k) = ToCount(NumberRanges()[k], pool.numbers[i][k]);
    long before = 0;
    for (int k = 0; k < kPoolAngles; ++k) {
      const long radius = std::lround(pool.radius[i][k] / kPackedRadius);
      counts(i, kSpecimenNumbers + k) = static_cast<uint16_t>(radius - before);
      before = radius;
    }
  }
  const nlohmann::ordered_json head = {{"format", kPackedFormat},
                                       {"version", kPackedVersion},
                                       {"mesh", pool.mesh},
                                       {"setting", pool.setting},
                                       {"specimen_diameter", 2 * pool.discs.specimen},
                                       {"support_diameter", 2 * pool.discs.support},
                                       {"seed", pool.seed},
                                       {"drapes", pool.num_drapes()}};
  const auto size = static_cast<uLong>(counts.size() * sizeof(uint16_t));
  std::vector<Bytef> packed(compressBound(size));
  uLongf used = packed.size();
  compress2(packed.data(), &used, reinterpret_cast<const Bytef*>(counts.data()), size,
            Z_BEST_COMPRESSION);
  return head.dump() + "\n" + std::string(packed.begin(), packed.begin() + static_cast<long>(used));
}

OutlinePool UnpackPool(std::string_view bytes, const std::string& where) {
  const std::size_t line = bytes.find('\n');
  const nlohmann::json json = nlohmann::json::parse(
      bytes.substr(0, line == std::string_view::npos ? 0 : line), nullptr, false);
  if (!json.is_object() || json.value("format", "") != kPackedFormat)
    throw InputError(where, "found other bytes, expected a pool of outlines");
  const JsonInput input(json, where);
  input.At("version").IntegerWithin(kPackedVersion, kPackedVersion);
  OutlinePool pool{.mesh = input.At("mesh").String(),
                   .setting = input.At("setting").String(),
                   .discs = {.specimen = input.At("specimen_diameter").NumberWithin(0.01, 10.0) / 2,
                             .support = input.At("support_diameter").NumberWithin(0.005, 10.0) / 2},
                   .seed = static_cast<uint64_t>(input.At("seed").IntegerWithin(0, 1 << 30)),
                   .numbers = {},
                   .radius = {}};
  Counts counts(input.At("drapes").IntegerWithin(1, kMostDrapes), kColumns);
  const auto expected = static_cast<uLong>(counts.size() * sizeof(uint16_t));
  uLongf size = expected;
  if (uncompress(reinterpret_cast<Bytef*>(counts.data()), &size,
                 reinterpret_cast<const Bytef*>(bytes.data() + line + 1),
                 static_cast<uLong>(bytes.size() - line - 1)) != Z_OK ||
      size != expected)
    throw InputError(where, "found damaged numbers, expected a pool as it was written");
  for (Eigen::Index i = 0; i < counts.rows(); ++i) {
    SpecimenNumbers& numbers = pool.numbers.emplace_back();
    for (int k = 0; k < kSpecimenNumbers; ++k)
      numbers[k] = FromCount(NumberRanges()[k], counts(i, k));
    Eigen::VectorXd& radius = pool.radius.emplace_back(kPoolAngles);
    uint16_t sum = 0;
    for (int k = 0; k < kPoolAngles; ++k) {
      sum = static_cast<uint16_t>(sum + counts(i, kSpecimenNumbers + k));
      radius[k] = kPackedRadius * sum;
    }
  }
  return pool;
}

const OutlinePool* FindBuiltInPool(const DrapeDiscs& discs) {
  static const std::vector<OutlinePool> pools = [] {
    std::vector<OutlinePool> unpacked;
    for (const std::string_view bytes : ListBuiltInPools())
      unpacked.push_back(UnpackPool(bytes, "built-in pool"));
    return unpacked;
  }();
  constexpr double kSameRatio = 1e-3;
  static std::mutex mutex;
  static std::map<std::pair<const OutlinePool*, double>, OutlinePool> scaled;
  for (const OutlinePool& pool : pools) {
    const double scale = discs.specimen / pool.discs.specimen;
    if (std::abs(discs.support / pool.discs.support / scale - 1.0) > kSameRatio) continue;
    if (pool.discs == discs) return &pool;
    const std::lock_guard lock(mutex);
    const auto [entry, is_new] = scaled.try_emplace({&pool, scale});
    if (is_new) entry->second = Scaled(pool, scale);
    return &entry->second;
  }
  return nullptr;
}

std::vector<PooledMatch> FindNearest(const OutlinePool& pool, const Eigen::VectorXd& radius,
                                     int count) {
  // No motion changes an outline's mean, and the difference of two means is at most their distance.
  // So drapes are tried by that difference, until it exceeds the distance of all that are kept.
  std::vector<std::pair<double, int>> by_mean;
  for (int i = 0; i < pool.num_drapes(); ++i)
    by_mean.emplace_back(std::abs(pool.radius[i].mean() - radius.mean()), i);
  std::sort(by_mean.begin(), by_mean.end());
  std::map<std::pair<double, int>, double> kept;  // distance and drape, rotation
  for (const auto& [least, i] : by_mean) {
    if (static_cast<int>(kept.size()) == count && least > kept.rbegin()->first.first) break;
    const OutlineMatch match =
        MatchOutlines(radius, pool.radius[i], OutlineFreedom::kRotationAndMirror);
    kept.emplace(std::pair(match.rms, i), match.rotation);
    if (static_cast<int>(kept.size()) > count) kept.erase(std::prev(kept.end()));
  }
  std::vector<PooledMatch> nearest;
  for (const auto& [found, rotation] : kept)
    nearest.push_back({.drape = found.second,
                       .distance = found.first,
                       .numbers = TurnedNumbers(pool.numbers[found.second], rotation)});
  return nearest;
}

PooledLength EstimateBendingLength(const OutlinePool& pool, const Eigen::VectorXd& radius) {
  constexpr int kLike = 50;
  constexpr double kEdge = 0.03;  // of the logarithm, from an end of the range
  const std::vector<PooledMatch> nearest = FindNearest(pool, radius, kLike + 1);
  const double farthest = nearest.back().distance;
  std::vector<std::pair<double, double>> lengths;  // ln c, weight
  double sum = 0.0;
  for (const PooledMatch& each : nearest) {
    const double weight = 1.0 - std::pow(each.distance / farthest, 2);  // 0 of the last
    lengths.emplace_back(each.numbers[kLogBendingLength], weight);
    sum += weight;
  }
  std::sort(lengths.begin(), lengths.end());
  const auto quantile = [&](double share) {
    double below = 0.0;
    for (const auto& [length, weight] : lengths)
      if ((below += weight) >= share * sum) return length;
    return lengths.back().first;
  };
  const NumberRange& range = NumberRanges()[kLogBendingLength];
  const double least = range.low + std::log(pool.scale) + kEdge,
               most = range.high + std::log(pool.scale) - kEdge;
  const double low = quantile(0.05), high = quantile(0.95);
  return {.low = std::exp(low),
          .median = std::exp(quantile(0.5)),
          .high = std::exp(high),
          .reaches_least = low<least, .reaches_most = high> most,
          .distance = nearest.front().distance};
}

SpecimenNumbers TurnedNumbers(const SpecimenNumbers& numbers, double angle) {
  // ln of bend over that of the mean: of edges along the weft, at 45° and along the warp.
  const double wave2 = numbers[kBendAnisotropy] / 2, bias = numbers[kBiasBend];
  const auto bend = [&](double direction) {
    return bias / 2 + wave2 * std::cos(2 * direction) - bias / 2 * std::cos(4 * direction);
  };
  const double weft = bend(-angle), warp = bend(M_PI / 2 - angle), mean = (weft + warp) / 2;
  SpecimenNumbers turned = numbers;
  turned[kLogBendingLength] += mean / 3;
  turned[kBendAnisotropy] = weft - warp;
  turned[kBiasBend] = (bend(M_PI / 4 - angle) + bend(-M_PI / 4 - angle)) / 2 - mean;
  turned[kStretchAnisotropy] *= std::cos(2 * angle);
  return turned;
}

}  // namespace drape
