// SPDX-License-Identifier: Apache-2.0
// What one drape says of its specimen, by the drapes of a pool that are like it.
#include "solver/prediction/generative/generative_prediction.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <random>

#include "losses/metrics/metrics.h"
#include "physics/util/errors.h"
#include "tests/solver/prediction/generative/fake_pool.h"

namespace drape::test {
namespace {

constexpr double kOutlineWeight = 0.2;

std::vector<double> ListValues(const SpecimenPosterior& posterior, int number) {
  std::vector<double> values;
  for (const SpecimenNumbers& sample : posterior.samples) values.push_back(sample[number]);
  return values;
}

// Chance in all that a camera sees; without it an outline would tell the stiffness exactly.
DrapePool WithChance(DrapePool pool) {
  std::mt19937_64 random(9);
  for (PooledDrape& drape : pool.drapes) {
    const double height = std::exp(0.3 * SampleNormal(random)), mean = drape.shape.radius.mean();
    drape.shape.features.tail<kNumBands>() *= height * height;
    drape.shape.radius = mean + height * (drape.shape.radius.array() - mean);
  }
  return pool;
}

TEST(SpecimenPosteriorTest, IntervalsHoldTheNumbersAsOftenAsTheySay) {
  const DrapePool pool = WithChance(FakePool(4000));
  const DrapePool known = WithChance(FakePool(300, 7));  // of other specimens
  std::array<int, kSpecimenNumbers> held = {};
  double width = 0.0;
  for (const PooledDrape& drape : known.drapes) {
    const SpecimenPosterior posterior =
        InferSpecimen(pool, {{1, ClothFace::kUp, drape.shape}}, kOutlineWeight, 99, 5);
    for (int k = 0; k < kSpecimenNumbers; ++k)
      held[k] += ComputeInterval(ListValues(posterior, k), 0.9).Contains(drape.numbers[k]);
    const CentralInterval length = ComputeInterval(ListValues(posterior, kLogBendingLength), 0.9);
    width += (length.high - length.low) / double(known.drapes.size());
  }
  for (int k = 0; k < kSpecimenNumbers; ++k) EXPECT_NEAR(held[k] / 300.0, 0.9, 0.06) << k;
  // The coefficient alone, whose deviation of .01 is .023 of ln c, would leave .076.
  EXPECT_NEAR(width, 0.07, 0.015);
}

TEST(SpecimenPosteriorTest, WhatNoDrapeShowsIsAsBefore) {
  const SpecimenPosterior posterior =
      InferSpecimen(FakePool(4000), FakeSamples(FakeFabric(), 1, 3), kOutlineWeight, 400, 1);
  EXPECT_GT(posterior.effective, 200.0);
  const NumberRange& shear = NumberRanges()[kLogShearRatio];
  const Spread spread = SpreadOfValues(ListValues(posterior, kLogShearRatio));
  EXPECT_NEAR(spread.mean, (shear.low + shear.high) / 2, 0.15 * (shear.high - shear.low));
  EXPECT_NEAR(spread.sd, (shear.high - shear.low) / std::sqrt(12.0),
              0.03 * (shear.high - shear.low));
}

TEST(SpecimenPosteriorTest, DoesNotDependOnHowThePoolWasDrawn) {
  // Half of the second pool shears easily, which no drape shows and weights undo.
  SpecimenDistribution soft = FakeFabric();
  soft.deviation.setConstant(2.0);
  soft.deviation[kLogShearRatio] = 0.4;
  for (SpecimenNumbers& mean : soft.mean) mean[kLogShearRatio] = std::log(0.05);
  const std::vector<TrainingDrape> seen = FakeSamples(FakeFabric(), 1, 3);
  const auto infer = [&](const DrapePool& pool) {
    return InferSpecimen(pool, {seen[0]}, kOutlineWeight, 1, 1);
  };
  const SpecimenPosterior uniform = infer(FakePool(8000)),
                          mixed = infer(Join(FakePool(6000), FakePoolAround(soft, 6000)));
  EXPECT_NEAR(uniform.mean[kLogBendingLength], FakeFabric().mean[0][kLogBendingLength], 0.1);
  EXPECT_NEAR(mixed.mean[kLogBendingLength], uniform.mean[kLogBendingLength], 0.02);
  EXPECT_NEAR(mixed.mean[kLogShearRatio], uniform.mean[kLogShearRatio], 0.35);
  EXPECT_LT(mixed.effective, 0.9 * uniform.effective);
}

TEST(SpecimenPosteriorTest, SeveralDrapesOfAFaceCountAsTheirMean) {
  const DrapePool pool = FakePool(4000);
  const std::vector<TrainingDrape> seen = FakeSamples(FakeFabric(), 1, 3);
  const auto length_of = [&](const std::vector<TrainingDrape>& drapes) {
    return InferSpecimen(pool, drapes, kOutlineWeight, 1, 1).mean[kLogBendingLength];
  };
  const double up = length_of({seen[0]}), down = length_of({seen[1]});
  EXPECT_LT(up + 0.05, down);
  EXPECT_NEAR(length_of({seen[0], seen[0]}), up, 1e-5);  // distances are of single precision
  EXPECT_NEAR(length_of({seen[0], seen[1]}), (up + down) / 2, 0.3 * (down - up));
}

TEST(SpecimenPosteriorTest, ADrapeLikeNoneOfThePoolIsNotExtrapolatedTo) {
  const DrapePool pool = FakePool(2000);
  std::vector<TrainingDrape> seen = {FakeSamples(FakeFabric(), 1, 3)[0]};
  EXPECT_TRUE(InferSpecimen(pool, seen, kOutlineWeight, 99, 1).has_like());
  seen[0].shape.features[0] = 2.0;  // more than the whole specimen
  const SpecimenPosterior posterior = InferSpecimen(pool, seen, kOutlineWeight, 99, 1);
  EXPECT_FALSE(posterior.has_like());
  const Spread length = SpreadOfValues(ListValues(posterior, kLogBendingLength));
  EXPECT_GT(length.sd, 0.02);
  EXPECT_GT(length.mean, std::log(0.02));  // the stiffest of the pool
}

TEST(SpecimenPosteriorTest, RefusesASmallPool) {
  try {
    InferSpecimen(FakePool(700), FakeSamples(FakeFabric(), 1, 3), kOutlineWeight, 1, 1);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "pool: found 700 drapes, expected at least 800");
  }
}

}  // namespace
}  // namespace drape::test
