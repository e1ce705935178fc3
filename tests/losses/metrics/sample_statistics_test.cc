// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/sample_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace drape {
namespace {

// The sleep data of Student 1908, a worked example of R (?sleep); quantiles by scipy.stats.
const std::vector<double> kFirst = {0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0},
                          kSecond = {1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4};

TEST(SampleStatistics, OneStratumHasStudentsInterval) {
  const SampleMean mean = MeanOfStrata({kFirst}, 0.0);
  EXPECT_NEAR(mean.mean, 0.75, 1e-12);
  EXPECT_NEAR(mean.deviation, 1.7890096577591623, 1e-12);
  EXPECT_EQ(mean.count, 10);
  EXPECT_NEAR(mean.HalfWidth().value(), 0.75 + 0.2870552787277869, 1e-9);
}

TEST(SampleStatistics, DifferenceHasWelchsInterval) {
  const SampleMean found =
      WelchDifference(MeanOfStrata({kFirst}, 0.0), MeanOfStrata({kSecond}, 0.0));
  EXPECT_NEAR(found.mean, -1.58, 1e-12);
  EXPECT_NEAR(found.freedom, 17.776473516178495, 1e-9);
  EXPECT_NEAR(found.HalfWidth().value(), 1.473381497331603, 1e-9);
}

// Values 1, 3 and 11, 13, 15 about 2 and 13: squares 2 + 8 over 5 − 2 degrees of freedom.
TEST(SampleStatistics, StrataAreWeighedAlikeAndPooled) {
  const SampleMean mean = MeanOfStrata({{1, 3}, {11, 13, 15}}, 0.0);
  EXPECT_NEAR(mean.mean, 7.5, 1e-12);
  EXPECT_NEAR(mean.freedom, 3, 1e-12);
  EXPECT_NEAR(mean.deviation, std::sqrt(10.0 / 3), 1e-12);
  EXPECT_NEAR(mean.standard_error, std::sqrt(10.0 / 3 * (1.0 / 2 + 1.0 / 3) / 4), 1e-12);
}

TEST(SampleStatistics, SpreadOfOneValueIsUnknown) {
  const SampleMean one = MeanOfStrata({{42}}, 0.5);
  EXPECT_FALSE(one.spread_is_known());
  EXPECT_FALSE(one.HalfWidth());
  EXPECT_FALSE(MeanOfStrata({{42}, {43}}, 0.5).HalfWidth());
  EXPECT_FALSE(WelchDifference(one, MeanOfStrata({kFirst}, 0.0)).HalfWidth());
}

// An error that all values share does not average out: equal values keep it.
TEST(SampleStatistics, SharedErrorWidensTheInterval) {
  EXPECT_NEAR(MeanOfStrata({{5, 5, 5}}, 0.5).HalfWidth().value(), 0.5 * 1.6448536269514722, 1e-9);
  EXPECT_NEAR(MeanOfStrata({kFirst}, 2.0).HalfWidth().value(),
              std::hypot(1.0370552787277869, 2.0 * 1.6448536269514722), 1e-9);
}

// Specimens differ, repeats scatter about them, and photographs share an error.
TEST(SampleStatistics, IntervalsHoldNineTimesInTen) {
  constexpr int kExperiments = 4000, kSpecimens = 3, kRepeats = 6;
  constexpr double kBetween = 1.5, kWithin = 1.0, kShared = 0.4;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int held = 0, of_repeats = 0;
  for (int i = 0; i < kExperiments; ++i) {
    const double error = kShared * normal(random);
    std::vector<double> specimens, all;
    for (int s = 0; s < kSpecimens; ++s) {
      const double specimen = kBetween * normal(random);
      double sum = 0.0;
      for (int r = 0; r < kRepeats; ++r) {
        all.push_back(specimen + kWithin * normal(random) + error);
        sum += all.back();
      }
      specimens.push_back(sum / kRepeats);
    }
    const SampleMean mean = MeanOfStrata({specimens}, kShared),
                     naive = MeanOfStrata({all}, kShared);
    held += std::abs(mean.mean) <= mean.HalfWidth().value();
    of_repeats += std::abs(naive.mean) <= naive.HalfWidth().value();
  }
  EXPECT_NEAR(double(held) / kExperiments, 0.9, 0.03);
  EXPECT_LT(double(of_repeats) / kExperiments, 0.8);  // repeats are not independent
}

}  // namespace
}  // namespace drape
