// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "losses/metrics/observed_drape.h"

namespace drape {

// How well a predicted distribution of drapes predicts held-out drapes [MODEL, M51].

// The rotation-invariant features that are scored, in this order.
inline constexpr int kNumFeatures = 2 + kNumBands;
inline constexpr std::array<const char*, kNumFeatures> kFeatureNames = {
    "dc", "folds", "band_2", "band_3_5", "band_6_9", "band_10_15"};
using FeatureVector = Eigen::Matrix<double, kNumFeatures, 1>;
FeatureVector ComputeFeatures(const ShapeFeatures& shape);  // bands in m²
// The features of several drapes, shape [kNumFeatures, drapes].
Eigen::MatrixXd ComputeFeatures(const std::vector<const ObservedDrape*>& drapes);

// The scale of each feature in the energy score: the scatter between samples of one fabric and
// face, pooled over fabrics 1–5 (240 images), so that the scores of different fabrics are
// comparable.
inline const FeatureVector kFeatureScales{0.027, 0.8, 4.9e-6, 9.7e-6, 1.1e-5, 5.5e-6};

// The fraction of observations inside central intervals, and the mean width of these.
struct IntervalSkill {
  double nominal = 0;  // the probability that the samples can reach (ComputeInterval)
  double coverage = 0;
  double width = 0;
};

struct FeatureScore {
  double observed_mean = 0;
  double predicted_mean = 0, predicted_sd = 0;
  double crps = 0;
  IntervalSkill half, ninety;  // intervals of 50 % and 90 %
};

// Scores as means over all observed drapes.
struct DistributionScore {
  int observed = 0;
  double mean_image_mse = 0;  // of the predictive mean image; NaN of features alone
  std::array<FeatureScore, kNumFeatures> features = {};
  double feature_energy = 0;  // energy score of the features, each divided by its scale
  // The energy score of the outlines r(θ) without alignment, by their root mean square distance
  // [m]. They are not aligned because a score by a distance that is minimised over rotations need
  // not favour the true distribution. NaN of features alone.
  double outline_energy = 0;
};

// Accumulates predictions, each of them an ensemble of at least two drapes, and the drapes observed
// for them.
class DistributionScorer {
 public:
  using Drapes = std::vector<const ObservedDrape*>;

  explicit DistributionScorer(const FeatureVector& scales = kFeatureScales) : scales_(scales) {}

  void Add(const Drapes& samples, const Drapes& observed);
  // A prediction of features alone, shapes [kNumFeatures, ≥ 2] and [kNumFeatures, observed]; then
  // the score is of features alone.
  void AddFeatures(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);
  DistributionScore Score() const;  // CHECKs that a drape was observed

 private:
  void SumFeatures(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);
  void AddFeature(int feature, const Eigen::VectorXd& samples, double observed);

  FeatureVector scales_;
  DistributionScore sum_;
  bool features_alone_ = false;
};

// How well an ensemble of samples from a predicted distribution predicts an observation
// [MODEL, M51]. A lower score is better, and its expectation is smallest for the true distribution.
// Both scores are the fair versions [Ferro 2014], so that ensembles of different sizes are
// comparable.

// The continuous ranked probability score, in the unit of the numbers: mean |X_i − y| − Σ_{i<j}
// |X_i − X_j| / (m(m−1)) over m ≥ 2 samples.
double EnsembleCrps(std::vector<double> samples, double observed);

// The energy score, which is the same for vectors with Euclidean distances
// [Gneiting 2007, section 4.3], for each column of `observed`, shape [d, n]. samples: shape [d, m],
// m ≥ 2.
Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed);

// The mean and standard deviation of values.
struct Spread {
  double mean = 0.0;
  double sd = 0.0;  // n − 1; 0 for one value
};
Spread SpreadOfValues(const std::vector<double>& values);

// The central interval by the quantiles at ranks p(m+1). Another sample of the same distribution
// lies in it with exactly the probability `nominal`, which is the requested one, or (m−1)/(m+1)
// when the samples are too few to reach it. m ≥ 2, 0 < probability < 1.
struct CentralInterval {
  double low = 0, high = 0;
  double nominal = 0;

  bool Contains(double value) const { return low <= value && value <= high; }
};
CentralInterval ComputeInterval(std::vector<double> samples, double probability);

}  // namespace drape
