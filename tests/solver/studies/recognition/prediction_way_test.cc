// SPDX-License-Identifier: Apache-2.0
// Fabrics recognised by predictions that are learned from fake drapes [METHODS, P62].
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "physics/util/errors.h"
#include "solver/studies/recognition/recognition.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/prediction/generative/fake_pool.h"

namespace drape::test {
namespace {

const DistributionFitOptions kOptions{.least_effective = 20.0, .threads = 2};

// One fabric for each bending length [m].
std::vector<SpecimenDistribution> FakeFabrics(const std::vector<double>& lengths) {
  std::vector<SpecimenDistribution> fabrics;
  for (const double length : lengths) {
    fabrics.push_back(FakeFabric());
    fabrics.back().mean[0][kLogBendingLength] = std::log(length);
    fabrics.back().mean[1][kLogBendingLength] = std::log(1.15 * length);
    fabrics.back().deviation[kLogBendingLength] = 0.08;
  }
  return fabrics;
}

std::vector<DrapesOfSample> DrawSamples(const std::vector<SpecimenDistribution>& fabrics,
                                        int samples) {
  std::vector<DrapesOfSample> list;
  for (std::size_t f = 0; f < fabrics.size(); ++f) {
    const std::vector<TrainingDrape> drapes = FakeSamples(fabrics[f], samples, 31 + f);
    for (std::size_t i = 0; i < drapes.size(); i += 2)  // both faces
      list.push_back({static_cast<int>(f), {drapes[i], drapes[i + 1]}});
  }
  return list;
}

struct WayScore {
  double top_1 = 0.0, log_loss = 0.0, sure = 0.0;  // means over the samples
};

Eigen::VectorXd Normalised(const Eigen::VectorXd& logs) {
  return logs.array() - logs.maxCoeff() - std::log((logs.array() - logs.maxCoeff()).exp().sum());
}

// With the factor of the log probabilities that has the least loss on the other samples.
WayScore Score(const std::vector<DrapesOfSample>& samples,
               const std::vector<Eigen::VectorXd>& logs) {
  const std::vector<double> factors = {0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0};
  const auto loss = [&](std::size_t sample, double factor) {
    return -Normalised(factor * logs[sample])[samples[sample].fabric];
  };
  const auto loss_of_others = [&](std::size_t sample, double factor) {
    double sum = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) sum += i == sample ? 0.0 : loss(i, factor);
    return sum;
  };
  WayScore score;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double factor = *std::min_element(
        factors.begin(), factors.end(),
        [&](double a, double b) { return loss_of_others(i, a) < loss_of_others(i, b); });
    int best = 0;
    score.sure += std::exp(Normalised(factor * logs[i]).maxCoeff(&best)) / double(samples.size());
    score.top_1 += (best == samples[i].fabric) / double(samples.size());
    score.log_loss += loss(i, factor) / double(samples.size());
  }
  return score;
}

TEST(PredictionWay, RecognisesFabricsThatDrapeUnlike) {
  const std::vector<DrapesOfSample> samples = DrawSamples(FakeFabrics({0.008, 0.013, 0.02}), 4);
  const WayScore score =
      Score(samples, CompareByPredictions(FakePool(2000), samples, 3, kOptions, {}));
  EXPECT_NEAR(score.top_1, 1.0, 1e-12);
  EXPECT_LT(score.log_loss, 0.02);
}

// Two whose means are 2.5 deviations apart: no way of telling them is always right.
TEST(PredictionWay, IsAsSureOfFabricsThatOverlapAsItIsRight) {
  const std::vector<DrapesOfSample> samples =
      DrawSamples(FakeFabrics({0.0141, 0.0141 * std::exp(0.2)}), 30);
  const WayScore score =
      Score(samples, CompareByPredictions(FakePool(1500), samples, 2, kOptions, {}));
  EXPECT_GT(score.top_1, 0.7);
  EXPECT_LT(score.top_1, 0.95);
  EXPECT_LT(score.log_loss, 0.5);  // ln 2 without any knowledge
  EXPECT_NEAR(score.sure, score.top_1, 0.08);
}

TEST(PredictionWay, LeavesTheSampleOutOfItsFabricAlone) {
  std::vector<DrapesOfSample> samples = DrawSamples(FakeFabrics({0.01, 0.018}), 3);
  samples[0].drapes = DrawSamples(FakeFabrics({0.0145}), 1)[0].drapes;  // unlike its fabric
  const DrapePool pool = FakePool(2000);
  const auto score = [&](const std::vector<int>& learned_from) {
    std::vector<TrainingDrape> training;
    for (const int i : learned_from)
      training.insert(training.end(), samples[i].drapes.begin(), samples[i].drapes.end());
    DistributionFitOptions options = kOptions;
    options.resamples = 0;
    options.cross_validate = false;
    const DistributionFit fit = FitDistribution(pool, training, options, {});
    return -ScoreDrapes(pool, fit.best, samples[0].drapes, options).sum();  // one of each face
  };
  const std::vector<Eigen::VectorXd> logs = CompareByPredictions(pool, samples, 2, kOptions, {});
  EXPECT_NEAR(logs[0][0], score({1, 2}), 1e-5);
  EXPECT_NEAR(logs[0][1], score({3, 4, 5}), 1e-5);
  EXPECT_GT(score({0, 1, 2}), logs[0][0] + 0.1);  // what it would be with the sample
}

TEST(PredictionWay, CapturesOfAFaceCountOnceAndThreadsDoNot) {
  std::vector<DrapesOfSample> samples = DrawSamples(FakeFabrics({0.01, 0.018}), 2);
  const DrapePool pool = FakePool(1500);
  DistributionFitOptions options = kOptions;
  const std::vector<Eigen::VectorXd> once = CompareByPredictions(pool, samples, 2, options, {});
  options.threads = 1;
  EXPECT_EQ(CompareByPredictions(pool, samples, 2, options, {}), once);
  samples[3].drapes.push_back(samples[3].drapes.back());
  const std::vector<Eigen::VectorXd> twice = CompareByPredictions(pool, samples, 2, options, {});
  for (const int f : {0, 1}) EXPECT_NEAR(twice[3][f], once[3][f], 1e-5) << f;
}

TEST(PredictionWay, EndsEarlyAndRefusesASmallPool) {
  const std::vector<DrapesOfSample> samples = DrawSamples(FakeFabrics({0.01, 0.018}), 2);
  const std::atomic<bool> cancel = true;
  EXPECT_TRUE(
      CompareByPredictions(FakePool(500), samples, 2, kOptions, {.cancel = &cancel}).empty());
  EXPECT_INPUT_ERROR(CompareByPredictions(FakePool(30), samples, 2, kOptions, {}), "pool: found");
}

}  // namespace
}  // namespace drape::test
