// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/parameters/coupled_table.h"

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

enum Column { kC11, kC12, kC22, kC33 };

// |ρ|/ρmax of a row, ρmax by that of the base; 0 where the base does not resist.
double CouplingShare(const double* base, const double* row) {
  if (!(base[kC11] > 0.0 && base[kC22] > 0.0)) return 0.0;
  const double start = std::abs(base[kC12]) / std::sqrt(base[kC11] * base[kC22]);
  if (start >= 1.0) return 0.0;
  const double largest = std::max(kLargestCoupling, 0.5 * (1.0 + start));
  return std::abs(row[kC12]) / (largest * std::sqrt(row[kC11] * row[kC22]));
}

}  // namespace

double LargestSquaredCoupling(const StretchTable& table) {
  double largest = 0.0;
  for (const auto& row : table.c)
    largest = std::max(largest, row[kC12] * row[kC12] / (row[kC11] * row[kC22]));
  return largest;
}

StretchTable ApplyLogFactors(const StretchTable& base, const double* log_factors) {
  StretchTable table;
  for (int r = 0; r < kStretchRows; ++r) {
    const double *from = base.c[r], *eta = log_factors + r * kStretchCols;
    double* row = table.c[r];
    for (const Column c : {kC11, kC22, kC33}) row[c] = from[c] * std::exp(eta[c]);
    const double mean = 0.5 * (eta[kC11] + eta[kC22]), u = eta[kC12] - mean;
    // e^u/(1 + q·(e^u − 1)) without overflow.
    const double slack = 1.0 - CouplingShare(from, from);
    row[kC12] = from[kC12] * std::exp(mean) / (1.0 + slack * std::expm1(-u));
  }
  return table;
}

Eigen::VectorXd FindLogFactors(const StretchTable& base, const StretchTable& table) {
  Eigen::VectorXd log_factors(kStretchEntries);
  for (int r = 0; r < kStretchRows; ++r) {
    const double *from = base.c[r], *to = table.c[r];
    double* eta = log_factors.data() + r * kStretchCols;
    for (const Column c : {kC11, kC22, kC33}) eta[c] = std::log(to[c] / from[c]);
    eta[kC12] = 0.5 * (eta[kC11] + eta[kC22]);
    if (from[kC12] == 0.0 && to[kC12] == 0.0) continue;
    // Both shares are on the scale of the base's ρmax: u = logit(share) − logit(share of the base).
    const double slack = 1.0 - CouplingShare(from, from), left = 1.0 - CouplingShare(from, to);
    eta[kC12] = std::log(to[kC12] / from[kC12] * slack / left);
  }
  return log_factors;
}

Eigen::VectorXd FindLogFactors(const MaterialField& base, const MaterialField& table) {
  Eigen::VectorXd factors(kMaterialEntries);
  factors.head(kStretchEntries) = FindLogFactors(base.stretch[0], table.stretch[0]);
  for (int i = 0; i < kBendEntries; ++i)
    factors[kStretchEntries + i] = std::log(table.bend[0].entries()[i] / base.bend[0].entries()[i]);
  return factors;
}

Eigen::VectorXd MeanLogFactors(const Eigen::MatrixXd& tie, const Eigen::VectorXd& log_factors) {
  return (tie.transpose() * log_factors).cwiseQuotient(tie.colwise().sum().transpose());
}

void PushLogFactors(const StretchTable& base, const StretchTable& table, double* change) {
  for (int r = 0; r < kStretchRows; ++r) {
    double* d = change + r * kStretchCols;
    const double share = CouplingShare(base.c[r], table.c[r]);
    d[kC12] = (1.0 - share) * d[kC12] + 0.5 * share * (d[kC11] + d[kC22]);
  }
}

void PullLogFactors(const StretchTable& base, const StretchTable& table, double* gradient) {
  for (int r = 0; r < kStretchRows; ++r) {
    double* g = gradient + r * kStretchCols;
    const double share = CouplingShare(base.c[r], table.c[r]);
    g[kC11] += 0.5 * share * g[kC12];
    g[kC22] += 0.5 * share * g[kC12];
    g[kC12] *= 1.0 - share;
  }
}

}  // namespace drape
