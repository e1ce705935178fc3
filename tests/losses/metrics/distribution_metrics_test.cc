// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <list>

#include "losses/metrics/metrics.h"

namespace drape {
namespace {

// Flat discs, whose features are known: DC from the radius, no folds, no bands.
class Discs {
 public:
  DistributionScorer::Drapes Of(const std::vector<double>& radii) {
    DistributionScorer::Drapes drapes;
    for (const double radius : radii) {
      kept_.push_back(ObserveDisc(radius, Camera(), {}));
      drapes.push_back(&kept_.back());
    }
    return drapes;
  }

 private:
  std::list<ObservedDrape> kept_;
};

double Coefficient(double radius) { return DrapeCoefficient(M_PI * radius * radius, {}); }

TEST(DistributionScorer, DiscsInClosedForm) {
  Discs discs;
  DistributionScorer scorer;
  scorer.Add(discs.Of({0.10, 0.12}), discs.Of({0.11, 0.13}));
  const DistributionScore score = scorer.Score();
  EXPECT_EQ(score.observed, 2);
  // The mean image has a ring of ½ between 10 and 12 cm; outside 12 cm it misses the second disc.
  const double px = 719.5 * 719.5 * M_PI / (256 * 256);
  const double first = 0.25 * (0.12 * 0.12 - 0.10 * 0.10);
  const double second = first + 0.13 * 0.13 - 0.12 * 0.12;
  EXPECT_NEAR(score.mean_image_mse, 0.5 * (first + second) * px, 2e-3);
  const FeatureScore& dc = score.features[0];
  const double low = Coefficient(0.10), high = Coefficient(0.12);
  EXPECT_NEAR(dc.predicted_mean, 0.5 * (low + high), 2e-3);
  EXPECT_NEAR(dc.predicted_sd, (high - low) / std::sqrt(2), 2e-3);
  EXPECT_NEAR(dc.observed_mean, 0.5 * (Coefficient(0.11) + Coefficient(0.13)), 2e-3);
  EXPECT_NEAR(dc.crps, 0.5 * (0 + Coefficient(0.13) - high), 3e-3);
  for (const IntervalSkill& skill : {dc.half, dc.ninety}) {
    EXPECT_NEAR(skill.nominal, 1.0 / 3, 1e-12);
    EXPECT_EQ(skill.coverage, 0.5);
    EXPECT_NEAR(skill.width, high - low, 3e-3);
  }
  EXPECT_EQ(score.features[1].crps, 0);
  EXPECT_NEAR(score.outline_energy, 0.5 * (0 + 0.01), 1e-4);
  EXPECT_NEAR(score.feature_energy, dc.crps / kFeatureScales[0], 0.02);
}

TEST(DistributionScorer, IsTheMeanOverAllPredictions) {
  Discs discs;
  const auto draws = discs.Of({0.10, 0.11, 0.125}), observed = discs.Of({0.11, 0.12, 0.14});
  DistributionScorer at_once, one_by_one;
  at_once.Add(draws, observed);
  for (const ObservedDrape* drape : observed) one_by_one.Add(draws, {drape});
  const DistributionScore a = at_once.Score(), b = one_by_one.Score();
  EXPECT_NEAR(a.mean_image_mse, b.mean_image_mse, 1e-12);
  EXPECT_NEAR(a.feature_energy, b.feature_energy, 1e-9);
  EXPECT_NEAR(a.outline_energy, b.outline_energy, 1e-12);
  EXPECT_NEAR(a.features[0].crps, b.features[0].crps, 1e-12);
  EXPECT_NEAR(a.features[0].half.coverage, b.features[0].half.coverage, 1e-12);
}

TEST(DistributionScorer, ScalesWeightTheFeatures) {
  Discs discs;
  const auto draws = discs.Of({0.10, 0.12}), observed = discs.Of({0.14});
  DistributionScorer twice(2 * kFeatureScales), once;
  twice.Add(draws, observed);
  once.Add(draws, observed);
  EXPECT_NEAR(2 * twice.Score().feature_energy, once.Score().feature_energy, 1e-9);
}

TEST(ComputeFeatures, AreInTheOrderOfTheirNames) {
  const FeatureVector f =
      ComputeFeatures({.drape_coefficient = 0.5, .folds = 7, .band_energy = {1, 2, 3, 4}});
  EXPECT_EQ(f, (FeatureVector() << 0.5, 7, 1, 2, 3, 4).finished());
  EXPECT_STREQ(kFeatureNames[5], "band_10_15");
}

}  // namespace
}  // namespace drape
