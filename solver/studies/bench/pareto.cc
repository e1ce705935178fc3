// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace drape {

namespace {

constexpr double kRounding = 1e-6;  // by which an error is no smaller than another, relative

}  // namespace

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
    if (points[i].error >= (1.0 - kRounding) * least) continue;
    least = points[i].error;
    front.push_back(i);
  }
  return front;
}

}  // namespace drape
