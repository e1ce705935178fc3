// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/shape_features.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <complex>

namespace drape {
namespace {

constexpr double kSmoothingAngle = 2 * M_PI / 180;  // [rad] standard deviation
constexpr int kBandEdges[kNumBands][2] = {{2, 2}, {3, 5}, {6, 9}, {10, 15}};

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

double DrapeCoefficient(double area) {
  const double support = M_PI * kSupportRadius * kSupportRadius;
  return (area - support) / (M_PI * kClothRadius * kClothRadius - support);
}

double ProfileArea(const Eigen::VectorXd& radius) {
  return M_PI * radius.squaredNorm() / radius.size();
}

// Makes one turn from the lowest point with hysteresis: a rise by min_prominence above the lowest
// point since the last fold, followed by a fall by min_prominence, is one peak of that prominence.
int CountFolds(const Eigen::VectorXd& radius, double min_prominence) {
  CHECK_GT(min_prominence, 0);
  const Eigen::VectorXd r = Smooth(radius);
  Eigen::Index start;
  double extreme = r.minCoeff(&start);
  bool rising = false;  // a rise by min_prominence has occurred
  int folds = 0;
  for (Eigen::Index i = 1; i <= r.size(); ++i) {
    const double value = r[(start + i) % r.size()];
    extreme = rising ? std::max(extreme, value) : std::min(extreme, value);
    const double change = rising ? extreme - value : value - extreme;
    if (change < min_prominence) continue;
    folds += rising;
    rising = !rising;
    extreme = value;
  }
  return folds;
}

std::array<double, kNumBands> BandEnergies(const Eigen::VectorXd& radius) {
  const int n = static_cast<int>(radius.size());
  CHECK_GT(n, 2 * kBandEdges[kNumBands - 1][1]);
  std::array<double, kNumBands> energy = {};
  for (int band = 0; band < kNumBands; ++band) {
    for (int k = kBandEdges[band][0]; k <= kBandEdges[band][1]; ++k) {
      std::complex<double> sum = 0;
      for (int i = 0; i < n; ++i) sum += radius[i] * std::polar(1.0, 2 * M_PI * k * i / n);
      energy[band] += 0.5 * std::norm(2.0 / n * sum);
    }
  }
  return energy;
}

Eigen::Matrix2Xd ProfilePolygon(const Eigen::VectorXd& radius) {
  Eigen::Matrix2Xd polygon(2, radius.size());
  for (Eigen::Index k = 0; k < radius.size(); ++k) {
    const double angle = 2 * M_PI * k / radius.size();
    polygon.col(k) = radius[k] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  return polygon;
}

double IsoperimetricRatio(const Eigen::VectorXd& radius) {
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius);
  double area = 0, length = 0;
  for (Eigen::Index k = 0; k < polygon.cols(); ++k) {
    const Eigen::Vector2d a = polygon.col(k), b = polygon.col((k + 1) % polygon.cols());
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
    length += (b - a).norm();
  }
  return 4 * M_PI * area / (length * length);
}

ShapeFeatures MeasureShape(const Eigen::VectorXd& radius) {
  ShapeFeatures features;
  features.drape_coefficient = DrapeCoefficient(ProfileArea(radius));
  features.folds = CountFolds(radius);
  features.band_energy = BandEnergies(radius);
  features.radius_min = radius.minCoeff();
  features.radius_max = radius.maxCoeff();
  features.isoperimetric_ratio = IsoperimetricRatio(radius);
  return features;
}

}  // namespace drape
