// SPDX-License-Identifier: Apache-2.0
// Distributions of specimens inferred by weighting drapes.
#include "solver/prediction/generative/distribution_fit.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "losses/metrics/metrics.h"
#include "physics/util/errors.h"
#include "tests/solver/prediction/generative/fake_pool.h"

namespace drape::test {
namespace {

class DistributionFitTest : public testing::Test {
 protected:
  const SpecimenDistribution fabric_ = FakeFabric();
  const std::vector<TrainingDrape> seen_ = FakeSamples(fabric_, 6, 21);
  DistributionFitOptions options_{.resamples = 8, .threads = 2};
};

TEST_F(DistributionFitTest, RecoversTheFabricThatWasDraped) {
  const DistributionFit fit = FitDistribution(FakePool(6000), seen_, options_, {});
  for (const int face : {0, 1}) {
    EXPECT_NEAR(fit.best.mean[face][kLogBendingLength], fabric_.mean[face][kLogBendingLength], 0.07)
        << face;
    EXPECT_NEAR(fit.best.mean[face][kBendAnisotropy], 1.2, 0.5) << face;
  }
  EXPECT_LT(fit.best.mean[0][kLogBendingLength], fit.best.mean[1][kLogBendingLength]);
  EXPECT_GE(fit.effective, 60.0);
  ASSERT_EQ(fit.resampled.size(), 8u);
  // Samples that were left out are predicted worse than those that were learned from.
  EXPECT_GT(fit.cross_validated, fit.score);
  EXPECT_LT(fit.cross_validated, 1.5 * fit.score);
}

TEST_F(DistributionFitTest, ResamplingShowsHowTheSamplesDiffer) {
  options_.resamples = 16;
  options_.cross_validate = false;
  const DrapePool pool = FakePool(6000);
  const auto spread_of = [&](const std::vector<TrainingDrape>& drapes) {
    std::vector<double> lengths;
    for (const SpecimenDistribution& each : FitDistribution(pool, drapes, options_, {}).resampled)
      lengths.push_back(each.mean[0][kLogBendingLength]);
    return SpreadOfValues(lengths).sd;
  };
  EXPECT_GT(spread_of(seen_), 5e-3);
  // Samples that drape alike, both faces of each.
  std::vector<TrainingDrape> alike = seen_;
  for (std::size_t i = 2; i < alike.size(); ++i) alike[i].shape = seen_[i % 2].shape;
  EXPECT_LT(spread_of(alike), 1e-3);
}

TEST_F(DistributionFitTest, FindsBothDirectionsOfBendWhereOnlyOutlinesTellThem) {
  options_ = {.outline_weight = 0.0, .resamples = 16, .cross_validate = false, .threads = 2};
  const DistributionFit fit = FitDistribution(FakePool(6000), seen_, options_, {});
  EXPECT_EQ(fit.best.mean[0], fit.minima.front().mean[0]);
  const auto bends_along = [](double sign) {
    return [sign](const SpecimenDistribution& each) {
      return sign * each.mean[0][kBendAnisotropy] > 0.3;
    };
  };
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_TRUE(std::any_of(fit.minima.begin(), fit.minima.end(), bends_along(sign))) << sign;
    EXPECT_TRUE(std::any_of(fit.resampled.begin(), fit.resampled.end(), bends_along(sign))) << sign;
  }
}

TEST_F(DistributionFitTest, ScoresAsUnweightedDrapesOfTheDistributionDo) {
  SpecimenDistribution one_face = fabric_;
  one_face.mean[1] = one_face.mean[0];
  const DrapePool pool = FakePoolAround(one_face, 1000);
  options_.outline_weight = 0.0;
  options_.least_effective = 1.0;
  Eigen::MatrixXd samples(kNumFeatures, 1000), observed(kNumFeatures, seen_.size());
  for (int i = 0; i < 1000; ++i)
    samples.col(i) = pool.drapes[i].shape.features.cwiseQuotient(kFeatureScales);
  for (std::size_t j = 0; j < seen_.size(); ++j)
    observed.col(j) = seen_[j].shape.features.cwiseQuotient(kFeatureScales);
  double effective = 0.0;
  const double score = ScoreDrapes(pool, one_face, seen_, options_, &effective).mean();
  EXPECT_NEAR(effective, 1000.0, 5.0);
  EXPECT_NEAR(score, EnergyScores(samples, observed).mean(), 0.01 * score);
}

TEST_F(DistributionFitTest, IsAMinimumOfTheScore) {
  const DrapePool pool = FakePool(3000);
  options_ = {.least_effective = 20.0, .resamples = 0, .cross_validate = false, .iterations = 200};
  const DistributionFit fit = FitDistribution(pool, seen_, options_, {});
  const double here = ScoreDrapes(pool, fit.best, seen_, options_).mean();
  // Two choices of drapes, of which twenty count.
  EXPECT_NEAR(here, fit.score, 0.15 * fit.score);
  for (const double step : {-0.2, 0.2}) {
    SpecimenDistribution moved = fit.best;
    for (auto& mean : moved.mean) mean[kLogBendingLength] += step;
    EXPECT_GT(ScoreDrapes(pool, moved, seen_, options_).mean(), 1.01 * here) << step;
  }
}

TEST_F(DistributionFitTest, DoesNotDependOnTheThreads) {
  const DrapePool pool = FakePool(2000);
  options_.least_effective = 20.0;
  const DistributionFit two = FitDistribution(pool, seen_, options_, {});
  options_.threads = 1;
  const DistributionFit one = FitDistribution(pool, seen_, options_, {});
  EXPECT_EQ(one.cross_validated, two.cross_validated);
  for (std::size_t i = 0; i < one.resampled.size(); ++i)
    EXPECT_EQ(one.resampled[i].mean[0], two.resampled[i].mean[0]) << i;
}

TEST_F(DistributionFitTest, AFaceThatWasNotSeenIsAsTheOther) {
  std::vector<TrainingDrape> up;
  for (const TrainingDrape& each : seen_)
    if (each.face == ClothFace::kUp) up.push_back(each);
  const DistributionFit fit = FitDistribution(FakePool(3000), up, options_, {});
  EXPECT_EQ(fit.best.mean[0], fit.best.mean[1]);
}

TEST_F(DistributionFitTest, RefusesAPoolWithoutDrapesNearTheFabric) {
  try {
    FitDistribution(FakePool(100), seen_, options_, {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("drapes near the fabric, expected at least 160"));
  }
}

TEST_F(DistributionFitTest, EndsEarlyWhenCancelled) {
  const std::atomic<bool> cancel = true;
  const DistributionFit fit = FitDistribution(FakePool(2000), seen_, options_, {.cancel = &cancel});
  EXPECT_TRUE(fit.resampled.empty());
}

}  // namespace
}  // namespace drape::test
