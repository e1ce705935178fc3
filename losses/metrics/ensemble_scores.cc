// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/ensemble_scores.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

// The value at rank `rank`, from 1 to the number of values, with linear interpolation between
// values.
double AtRank(const std::vector<double>& sorted, double rank) {
  const double last = static_cast<double>(sorted.size()) - 1;
  const double position = std::clamp(rank - 1, 0.0, last);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - below) * (sorted[above] - sorted[below]);
}

}  // namespace

double EnsembleCrps(std::vector<double> samples, double observed) {
  CHECK_GE(samples.size(), 2u);
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  double distance = 0, spread = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    distance += std::abs(samples[i] - observed) / m;
    spread += (2.0 * i - m + 1) * samples[i];  // Σ_{i<j} (x_j − x_i) of sorted samples
  }
  return distance - spread / (m * (m - 1));
}

Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed) {
  CHECK_GE(samples.cols(), 2);
  CHECK_EQ(samples.rows(), observed.rows());
  const double m = static_cast<double>(samples.cols());
  double spread = 0;
  for (Eigen::Index i = 1; i < samples.cols(); ++i)
    spread += (samples.leftCols(i).colwise() - samples.col(i)).colwise().norm().sum();
  Eigen::VectorXd scores(observed.cols());
  for (Eigen::Index i = 0; i < observed.cols(); ++i) {
    scores[i] =
        (samples.colwise() - observed.col(i)).colwise().norm().mean() - spread / (m * (m - 1));
  }
  return scores;
}

CentralInterval ComputeInterval(std::vector<double> samples, double probability) {
  CHECK_GE(samples.size(), 2u);
  CHECK(probability > 0 && probability < 1) << probability;
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  const double nominal = std::min(probability, (m - 1) / (m + 1));
  const double rank = 0.5 * (1 - nominal) * (m + 1);
  return {AtRank(samples, rank), AtRank(samples, m + 1 - rank), nominal};
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
