// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "losses/metrics/observed_drape.h"

namespace drape {

// How well a predicted distribution of drapes foretells drapes that were not learnt from
// [MODEL, M51].

// The rotation-invariant numbers that are scored, in this order.
inline constexpr int kNumFeatures = 2 + kNumBands;
inline constexpr std::array<const char*, kNumFeatures> kFeatureNames = {
    "dc", "folds", "band_2", "band_3_5", "band_6_9", "band_10_15"};
using FeatureVector = Eigen::Matrix<double, kNumFeatures, 1>;
FeatureVector ComputeFeatures(const ShapeFeatures& shape);  // bands in m²

// What one of them counts in the energy score: the scatter between samples of one fabric and face,
// pooled over fabrics 1–5 (240 images), so that scores of different fabrics compare.
inline const FeatureVector kFeatureScales{0.027, 0.8, 4.9e-6, 9.7e-6, 1.1e-5, 5.5e-6};

// How often the observed lie in central intervals, and how wide these are, in the mean.
struct IntervalSkill {
  double nominal = 0;  // of what the draws can reach (ComputeInterval)
  double coverage = 0;
  double width = 0;
};

struct FeatureScore {
  double observed_mean = 0;
  double predicted_mean = 0, predicted_sd = 0;
  double crps = 0;
  IntervalSkill half, ninety;  // of 50 % and 90 %
};

// Means over all observed drapes.
struct DistributionScore {
  int observed = 0;
  double mean_image_mse = 0;  // of the predictive mean image
  std::array<FeatureScore, kNumFeatures> features = {};
  double feature_energy = 0;  // energy score of the features, each divided by its scale
  // Of the outlines r(θ) as they lie, by their root mean square distance [m]. Not aligned: with a
  // distance that is least over rotations the score need not favour the true distribution.
  double outline_energy = 0;
};

// Adds up predictions, each an ensemble of at least two drapes, and what they were to foretell.
class DistributionScorer {
 public:
  using Drapes = std::vector<const ObservedDrape*>;

  explicit DistributionScorer(const FeatureVector& scales = kFeatureScales) : scales_(scales) {}

  void Add(const Drapes& draws, const Drapes& observed);
  DistributionScore Score() const;  // at least one observed

 private:
  void AddFeature(int feature, const Eigen::VectorXd& draws, double observed);

  FeatureVector scales_;
  DistributionScore sum_;
};

}  // namespace drape
