// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/pareto.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace drape {

std::vector<int> ParetoFront(const std::vector<CostAndError>& points) {
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error)) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::tie(points[a].cost, points[a].error, a) <
           std::tie(points[b].cost, points[b].error, b);
  });
  std::vector<int> front;
  double least = std::numeric_limits<double>::infinity();
  for (const int i : order) {
    if (points[i].error >= least) continue;
    least = points[i].error;
    front.push_back(i);
  }
  return front;
}

double FittedExponent(const std::vector<double>& x, const std::vector<double>& y) {
  CHECK_EQ(x.size(), y.size());
  double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0;
  const double n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    CHECK(x[i] > 0 && y[i] > 0) << x[i] << " " << y[i];
    mean_x += std::log(x[i]) / n;
    mean_y += std::log(y[i]) / n;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = std::log(x[i]) - mean_x;
    xx += dx * dx;
    xy += dx * (std::log(y[i]) - mean_y);
  }
  CHECK_GT(xx, 0.0);
  return xy / xx;
}

}  // namespace drape
