// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/performance_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drape {

double SpentToReach(const std::vector<TracePoint>& trace, double target, BudgetUnit unit) {
  for (const TracePoint& point : trace)
    if (point.cost <= target) return unit == BudgetUnit::kBudget ? point.spent : point.seconds;
  return std::numeric_limits<double>::infinity();
}

double SolvedBelow(double start, double best, double tolerance) {
  return best + tolerance * (start - best);
}

Eigen::MatrixXd PerformanceRatios(const Eigen::MatrixXd& spent) {
  Eigen::MatrixXd ratios = spent;
  for (Eigen::Index problem = 0; problem < spent.rows(); ++problem) {
    const double least = spent.row(problem).minCoeff();
    if (std::isfinite(least)) ratios.row(problem) /= least;
  }
  return ratios;
}

double ProfileAt(const Eigen::VectorXd& ratios, double factor) {
  return static_cast<double>((ratios.array() <= factor).count()) /
         static_cast<double>(ratios.size());
}

std::vector<ProfileStep> ProfileSteps(const Eigen::VectorXd& ratios) {
  std::vector<double> factors = {1.0};
  for (const double ratio : ratios)
    if (std::isfinite(ratio)) factors.push_back(ratio);
  std::sort(factors.begin(), factors.end());
  factors.erase(std::unique(factors.begin(), factors.end()), factors.end());
  std::vector<ProfileStep> steps;
  for (const double factor : factors) steps.push_back({factor, ProfileAt(ratios, factor)});
  return steps;
}

}  // namespace drape
