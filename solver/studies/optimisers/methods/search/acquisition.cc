// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/search/acquisition.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "physics/util/math/random.h"

namespace drape {

double ExpectedImprovement(double mean, double deviation, double least) {
  const double gain = least - mean;
  if (!(deviation > 0.0)) return std::max(gain, 0.0);
  const double z = gain / deviation;
  const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2);  // Φ(z)
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
  return gain * below + deviation * density;
}

double UpperConfidenceBound(double mean, double deviation, int evaluations, int dimension) {
  constexpr double kPi = std::numbers::pi;
  const double log_argument = (0.5 * dimension + 2.0) * std::log(static_cast<double>(evaluations)) +
                              std::log(kPi * kPi / 0.3);
  return -mean + deviation * std::sqrt(2.0 * log_argument);
}

Eigen::MatrixXd SampleLatinHypercube(int dimension, int count, std::mt19937_64& random) {
  Eigen::MatrixXd points(dimension, count);
  std::vector<int> order(count);
  for (int row = 0; row < dimension; ++row) {
    std::iota(order.begin(), order.end(), 0);
    for (int i = count - 1; i > 0; --i)  // Fisher–Yates, the same on every platform
      std::swap(order[i], order[static_cast<int>(SampleUniform(random) * (i + 1))]);
    for (int i = 0; i < count; ++i)
      points(row, i) = 2.0 * (order[i] + SampleUniform(random)) / count - 1.0;
  }
  return points;
}

}  // namespace drape
