// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/ensemble_scores.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

// At rank `rank` from 1 to the number of values, between values linearly.
double AtRank(const std::vector<double>& sorted, double rank) {
  const double last = static_cast<double>(sorted.size()) - 1;
  const double position = std::clamp(rank - 1, 0.0, last);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - below) * (sorted[above] - sorted[below]);
}

}  // namespace

double EnsembleCrps(std::vector<double> draws, double observed) {
  CHECK_GE(draws.size(), 2u);
  std::sort(draws.begin(), draws.end());
  const double m = static_cast<double>(draws.size());
  double distance = 0, spread = 0;
  for (size_t i = 0; i < draws.size(); ++i) {
    distance += std::abs(draws[i] - observed) / m;
    spread += (2.0 * i - m + 1) * draws[i];  // Σ_{i<j} (x_j − x_i) of sorted draws
  }
  return distance - spread / (m * (m - 1));
}

Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& draws, const Eigen::MatrixXd& observed) {
  CHECK_GE(draws.cols(), 2);
  CHECK_EQ(draws.rows(), observed.rows());
  const double m = static_cast<double>(draws.cols());
  double spread = 0;
  for (Eigen::Index i = 1; i < draws.cols(); ++i)
    spread += (draws.leftCols(i).colwise() - draws.col(i)).colwise().norm().sum();
  Eigen::VectorXd scores(observed.cols());
  for (Eigen::Index i = 0; i < observed.cols(); ++i) {
    scores[i] =
        (draws.colwise() - observed.col(i)).colwise().norm().mean() - spread / (m * (m - 1));
  }
  return scores;
}

CentralInterval ComputeInterval(std::vector<double> draws, double probability) {
  CHECK_GE(draws.size(), 2u);
  CHECK(probability > 0 && probability < 1) << probability;
  std::sort(draws.begin(), draws.end());
  const double m = static_cast<double>(draws.size());
  const double nominal = std::min(probability, (m - 1) / (m + 1));
  const double rank = 0.5 * (1 - nominal) * (m + 1);
  return {AtRank(draws, rank), AtRank(draws, m + 1 - rank), nominal};
}

Spread SpreadOfValues(const std::vector<double>& values) {
  Spread spread;
  if (values.empty()) return spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  if (values.size() == 1) return spread;
  double squares = 0.0;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  spread.sd = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return spread;
}

}  // namespace drape
