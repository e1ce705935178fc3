// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/laboratory_drape.h"

#include <algorithm>
#include <cmath>

#include "losses/outline/folds.h"
#include "losses/outline/shape_features.h"

namespace drape {
namespace {

constexpr double kPercent = 100.0;

Eigen::Vector2d PointAt(const Eigen::VectorXd& radius, int k) {
  const double angle = 2 * M_PI * k / static_cast<double>(radius.size());
  return radius[k] * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

struct MeanAndDeviation {
  double mean = 0.0, deviation = 0.0;
};
MeanAndDeviation Describe(const std::vector<double>& values) {
  if (values.empty()) return {};
  // A copy: sums over a vector's own memory depend in their last bits on where it lies.
  const Eigen::ArrayXd all =
      Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return {all.mean(), std::sqrt((all - all.mean()).square().mean())};
}

std::vector<double> Spacings(const std::vector<DrapeNode>& nodes) {
  std::vector<double> spacings;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double turn = i + 1 < nodes.size() ? 0.0 : 2 * M_PI;
    spacings.push_back(nodes[(i + 1) % nodes.size()].angle + turn - nodes[i].angle);
  }
  return spacings;
}

}  // namespace

std::vector<DrapeNode> FindNodes(const Eigen::VectorXd& radius, double min_prominence) {
  const std::vector<Fold> folds = FindFolds(radius, min_prominence);
  std::vector<DrapeNode> nodes;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    const int before = folds[i].valley, after = folds[(i + 1) % folds.size()].valley;
    const double peak = radius[folds[i].peak];
    nodes.push_back({.angle = 2 * M_PI * folds[i].peak / static_cast<double>(radius.size()),
                     .radius = peak,
                     .height = peak - 0.5 * (radius[before] + radius[after]),
                     .width = (PointAt(radius, after) - PointAt(radius, before)).norm()});
  }
  if (nodes.size() == 1) nodes[0].width = 2 * radius[folds[0].valley];  // both valleys are one
  std::sort(nodes.begin(), nodes.end(),
            [](const DrapeNode& a, const DrapeNode& b) { return a.angle < b.angle; });
  return nodes;
}

LaboratoryDrape MeasureLaboratoryDrape(const Eigen::VectorXd& radius, const DrapeDiscs& discs) {
  LaboratoryDrape drape{.discs = discs, .nodes = FindNodes(radius)};
  const double overhang = discs.specimen - discs.support;
  std::vector<double> heights, severities;
  for (const DrapeNode& node : drape.nodes) {
    heights.push_back(node.height);
    severities.push_back(node.severity());
  }
  const MeanAndDeviation spacing = Describe(Spacings(drape.nodes));
  const MeanAndDeviation severity = Describe(severities);
  const double height = Describe(heights).mean;
  drape.drape_coefficient = kPercent * DrapeCoefficient(ProfileArea(radius), discs);
  drape.spacing_mean = spacing.mean;
  drape.spacing_variation = spacing.mean > 0 ? spacing.deviation / spacing.mean : 0.0;
  drape.severity_mean = severity.mean;
  drape.severity_deviation = severity.deviation;
  drape.distance_ratio = kPercent * (discs.specimen - radius.mean()) / overhang;
  drape.fold_depth_index = kPercent * height / overhang;
  drape.amplitude_ratio = kPercent * 0.5 * height / radius.mean();
  drape.circularity = IsoperimetricRatio(radius);
  return drape;
}

}  // namespace drape
