// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/folds.h"

#include <glog/logging.h>

#include <cmath>

namespace drape {
namespace {

constexpr double kSmoothingAngle = 2 * M_PI / 180;  // [rad] standard deviation

// Smooths by a circular Gaussian that is cut at 4 standard deviations.
Eigen::VectorXd Smooth(const Eigen::VectorXd& radius) {
  const int n = static_cast<int>(radius.size());
  const double spacing = 2 * M_PI / n;
  const int reach = static_cast<int>(4 * kSmoothingAngle / spacing);
  Eigen::VectorXd smooth = Eigen::VectorXd::Zero(n);
  double sum = 0;
  for (int d = -reach; d <= reach; ++d) {
    const double weight = std::exp(-0.5 * std::pow(d * spacing / kSmoothingAngle, 2));
    sum += weight;
    for (int k = 0; k < n; ++k) smooth[k] += weight * radius[((k + d) % n + n) % n];
  }
  return smooth / sum;
}

}  // namespace

// Makes one turn from the lowest point with hysteresis: a rise by min_prominence above the lowest
// point since the last fold, followed by a fall by min_prominence, is one peak of that prominence.
std::vector<Fold> FindFolds(const Eigen::VectorXd& radius, double min_prominence) {
  CHECK_GT(min_prominence, 0);
  const Eigen::VectorXd r = Smooth(radius);
  const int n = static_cast<int>(r.size());
  int start = 0, extreme = 0;
  r.minCoeff(&start);
  extreme = start;
  bool rising = false;  // a rise by min_prominence has occurred
  std::vector<Fold> folds;
  int valley = start;
  for (int i = 1; i <= n; ++i) {
    const int k = (start + i) % n;
    const double sign = rising ? 1.0 : -1.0;
    if (sign * r[k] > sign * r[extreme]) extreme = k;
    if (sign * (r[extreme] - r[k]) < min_prominence) continue;
    if (rising)
      folds.push_back({valley, extreme});
    else
      valley = extreme;
    rising = !rising;
    extreme = k;
  }
  return folds;
}

}  // namespace drape
