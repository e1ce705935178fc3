// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/variational/pareto_smoothing.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace drape {
namespace {

// The profile estimate of k for exceedances x > 0, ascending.
double ZhangStephens(const Eigen::ArrayXd& x) {
  constexpr double kPrior = 3.0;
  const auto n = static_cast<double>(x.size());
  const int points = 30 + static_cast<int>(std::sqrt(n));
  const double quartile = x[static_cast<Eigen::Index>(std::floor(n / 4 + 0.5)) - 1];
  Eigen::ArrayXd theta(points), likelihood(points);
  const auto shape = [&](double t) { return (1 - t * x).log().mean(); };
  for (int j = 0; j < points; ++j) {
    theta[j] = 1 / x[x.size() - 1] + (1 - std::sqrt(points / (j + 0.5))) / (kPrior * quartile);
    const double k = shape(theta[j]);
    likelihood[j] = n * (std::log(-theta[j] / k) - k - 1);
  }
  const Eigen::ArrayXd weight = (likelihood - likelihood.maxCoeff()).exp();
  return shape((weight * theta).sum() / weight.sum());
}

}  // namespace

double ParetoShape(const Eigen::VectorXd& log_weights) {
  constexpr double kTowards = 0.5, kTowardsCount = 10.0;
  CHECK_GE(log_weights.size(), 25);
  CHECK(log_weights.allFinite());
  Eigen::VectorXd sorted = log_weights.array() - log_weights.maxCoeff();
  if (sorted.minCoeff() == 0.0) return 0.0;
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  const auto tail = static_cast<Eigen::Index>(std::ceil(std::min(0.2 * n, 3 * std::sqrt(n))));
  const double cut = std::exp(sorted[sorted.size() - tail - 1]);
  const Eigen::ArrayXd above = sorted.tail(tail).array().exp() - cut;
  const Eigen::Index positive = (above > 0).count();
  if (positive < 5) return std::numeric_limits<double>::infinity();
  const double k = ZhangStephens(above.tail(positive));
  const auto count = static_cast<double>(positive);
  return (count * k + kTowardsCount * kTowards) / (count + kTowardsCount);
}

}  // namespace drape
