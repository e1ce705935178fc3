// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/shape_features.h"

#include <glog/logging.h>

#include <cmath>
#include <complex>

#include "losses/outline/folds.h"

namespace drape {
namespace {

constexpr int kBandEdges[kNumBands][2] = {{2, 2}, {3, 5}, {6, 9}, {10, 15}};

}  // namespace

double DrapeCoefficient(double area, const DrapeDiscs& discs) {
  const double support = M_PI * discs.support * discs.support;
  return (area - support) / (M_PI * discs.specimen * discs.specimen - support);
}

double ProfileArea(const Eigen::VectorXd& radius) {
  return M_PI * radius.squaredNorm() / radius.size();
}

int CountFolds(const Eigen::VectorXd& radius, double min_prominence) {
  return static_cast<int>(FindFolds(radius, min_prominence).size());
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

ShapeFeatures MeasureShape(const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  ShapeFeatures features;
  features.drape_coefficient = DrapeCoefficient(ProfileArea(radius), discs);
  features.folds = CountFolds(radius);
  features.band_energy = BandEnergies(radius);
  features.radius_min = radius.minCoeff();
  features.radius_max = radius.maxCoeff();
  features.isoperimetric_ratio = IsoperimetricRatio(radius);
  return features;
}

}  // namespace drape
