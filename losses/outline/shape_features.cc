// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/shape_features.h"

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

constexpr int kBandEdges[kNumBands][2] = {{2, 2}, {3, 5}, {6, 9}, {10, 15}};

// cos kθ + i·sin kθ at angle i of n.
std::complex<double> Wave(int k, int i, int n) { return std::polar(1.0, 2 * M_PI * k * i / n); }

// Twice the signed area between the axis and the edge from a to b.
double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
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

std::complex<double> ComputeMode(const Eigen::VectorXd& radius, int k) {
  const int n = static_cast<int>(radius.size());
  std::complex<double> sum = 0;
  for (int i = 0; i < n; ++i) sum += radius[i] * Wave(k, i, n);
  return 2.0 / n * sum;
}

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
    for (int k = kBandEdges[band][0]; k <= kBandEdges[band][1]; ++k)
      energy[band] += 0.5 * std::norm(ComputeMode(radius, k));
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
    area += 0.5 * Cross(a, b);
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

ShapeFeatureVector ListShapeFeatures(const ShapeFeatures& features) {
  const auto& bands = features.band_energy;
  ShapeFeatureVector list;
  list << features.drape_coefficient, features.folds, bands[0], bands[1], bands[2], bands[3],
      features.radius_min, features.radius_max, features.isoperimetric_ratio;
  return list;
}

namespace {

// ∂(½ Σ a_k² of a band)/∂r.
Eigen::VectorXd BandEnergyGradient(const Eigen::VectorXd& radius, int band) {
  const int n = static_cast<int>(radius.size());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (int k = kBandEdges[band][0]; k <= kBandEdges[band][1]; ++k) {
    const std::complex<double> mode = ComputeMode(radius, k);
    for (int i = 0; i < n; ++i) gradient[i] += 2.0 / n * (std::conj(mode) * Wave(k, i, n)).real();
  }
  return gradient;
}

// ∂(4πA/L²)/∂r.
Eigen::VectorXd IsoperimetricGradient(const Eigen::VectorXd& radius) {
  const Eigen::Matrix2Xd polygon = ProfilePolygon(radius);
  const Eigen::Matrix2Xd along = ProfilePolygon(Eigen::VectorXd::Ones(radius.size()));
  const Eigen::Index n = polygon.cols();
  Eigen::VectorXd by_area = Eigen::VectorXd::Zero(n), by_length = by_area;  // ∂A/∂r, ∂L/∂r
  double area = 0, length = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index next = (k + 1) % n;
    const Eigen::Vector2d a = polygon.col(k), b = polygon.col(next), edge = (b - a).normalized();
    area += 0.5 * Cross(a, b);
    length += (b - a).norm();
    by_area[k] += 0.5 * Cross(along.col(k), b);
    by_area[next] += 0.5 * Cross(a, along.col(next));
    by_length[k] -= edge.dot(along.col(k));
    by_length[next] += edge.dot(along.col(next));
  }
  return 4 * M_PI / (length * length) * (by_area - 2 * area / length * by_length);
}

}  // namespace

Eigen::Matrix<double, kNumShapeFeatures, Eigen::Dynamic> ShapeFeatureJacobian(
    const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  const Eigen::Index n = radius.size();
  Eigen::Matrix<double, kNumShapeFeatures, Eigen::Dynamic> jacobian(kNumShapeFeatures, n);
  jacobian.setZero();
  // The coefficient is linear in the area, whose gradient is 2π/n·r.
  const double by_area = DrapeCoefficient(1.0, discs) - DrapeCoefficient(0.0, discs);
  jacobian.row(0) = by_area * 2 * M_PI / static_cast<double>(n) * radius;
  for (int band = 0; band < kNumBands; ++band)
    jacobian.row(2 + band) = BandEnergyGradient(radius, band);
  Eigen::Index least = 0, most = 0;
  radius.minCoeff(&least);
  radius.maxCoeff(&most);
  jacobian(2 + kNumBands, least) = 1.0;
  jacobian(3 + kNumBands, most) = 1.0;
  jacobian.row(4 + kNumBands) = IsoperimetricGradient(radius);
  return jacobian;
}

}  // namespace drape
