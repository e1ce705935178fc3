// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/sample_statistics.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

namespace drape {

std::optional<double> SampleMean::HalfWidth() const {
  constexpr double kUpper = 0.95;  // the upper end of an interval of 90 %
  if (!spread_is_known()) return std::nullopt;
  return std::hypot(standard_error * quantile(boost::math::students_t(freedom), kUpper),
                    shared * quantile(boost::math::normal(), kUpper));
}

SampleMean MeanOfStrata(const std::vector<std::vector<double>>& strata, double shared) {
  const auto number = static_cast<double>(strata.size());
  SampleMean result{.shared = shared};
  double squares = 0.0, weights = 0.0;
  for (const std::vector<double>& values : strata) {
    const auto count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    for (const double value : values) squares += (value - mean) * (value - mean);
    result.mean += mean / number;
    result.count += static_cast<int>(values.size());
    weights += 1.0 / (number * number * count);
  }
  result.freedom = result.count - number;
  if (!result.spread_is_known()) return result;
  result.deviation = std::sqrt(squares / result.freedom);
  result.standard_error = result.deviation * std::sqrt(weights);
  return result;
}

SampleMean WelchDifference(const SampleMean& a, const SampleMean& b) {
  SampleMean result{.mean = a.mean - b.mean,
                    .count = a.count + b.count,
                    .standard_error = std::hypot(a.standard_error, b.standard_error),
                    .shared = std::hypot(a.shared, b.shared)};
  if (!a.spread_is_known() || !b.spread_is_known()) return result;
  // Shares of the variance: a fabric that does not vary leaves the freedom to the other one.
  const double variance = result.standard_error * result.standard_error;
  const double share = variance > 0.0 ? a.standard_error * a.standard_error / variance : 0.5;
  result.freedom = 1.0 / (share * share / a.freedom + (1.0 - share) * (1.0 - share) / b.freedom);
  return result;
}

}  // namespace drape
