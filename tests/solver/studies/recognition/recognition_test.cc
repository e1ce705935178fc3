// SPDX-License-Identifier: Apache-2.0
// Cells and samples of recognition; fits that fail do not end a run [METHODS, P62].
#include "solver/studies/recognition/recognition.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/prediction/generative/fake_pool.h"

namespace drape::test {
namespace {

class FabricFitsTest : public FileFixture {};

TEST_F(FabricFitsTest, CellsAreByFabricOrBySample) {
  const std::vector<Capture> captures = {{1, 1, 1}, {1, 1, 2}, {1, 2, 1}, {4, 2, 1}};
  const std::vector<FitCell> fabrics = MakeFitCells(captures, false),
                             samples = MakeFitCells(captures, true);
  ASSERT_EQ(fabrics.size(), 2u);
  EXPECT_EQ(fabrics[0].name, "fabric_1");
  EXPECT_EQ(fabrics[0].captures.size(), 3u);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[2].name, "fabric_4/sample_2");
}

TEST_F(FabricFitsTest, AFabricWithOneSampleIsNotRecognised) {
  const std::vector<Capture> captures = {{1, 1, 1}, {1, 2, 1}, {2, 1, 1},
                                         {4, 2, 1}, {4, 5, 1}, {4, 5, 2}};
  const std::vector<FitCell> cells = MakeFitCells(captures, true);
  std::vector<ObservedCapture> images;
  for (const Capture& capture : captures) images.push_back({capture, {}});
  std::vector<std::string> names;
  for (const FitCell& cell : cells) names.push_back(cell.name);
  const SampleList list = ListSamples(cells, names, images);
  EXPECT_EQ(list.fabrics, (std::vector<int>{1, 4}));
  ASSERT_EQ(list.samples.size(), 4u);
  EXPECT_EQ(list.samples[3].name, "fabric_4/sample_5");
  EXPECT_EQ(list.samples[3].fabric, 1);
  ASSERT_EQ(list.samples[3].images.size(), 2u);
  EXPECT_EQ(list.samples[3].images[0], &images[4]);
  names.erase(names.begin());  // as if its fit had failed
  EXPECT_INPUT_ERROR(ListSamples(cells, names, images), "found 1 fabric(s) with two samples");
}

// Images that are no silhouettes: each failure is named and kept, and the run ends.
TEST_F(FabricFitsTest, AFailureIsNamedAndEndsNothing) {
  WriteMaterial(Path("start.json"), {.name = "start",
                                     .field = TestMaterial(),
                                     .source_convention = "arcsim",
                                     .source = "",
                                     .warnings = {}});
  Write("bad.jpg", "no image");
  FitCellJob job;
  job.material = Path("start.json");
  job.study.out = Path("fits");
  job.study.threads = 2;
  job.fit.model = FitModel::kBayes;
  job.settings = {{"mesh", "a"}};
  const std::vector<FitCell> cells = MakeFitCells(
      {{1, 1, 1, ClothFace::kUp, Path("bad.jpg")}, {2, 1, 1, ClothFace::kUp, Path("none.jpg")}},
      false);
  const auto stored = [&] {
    const std::filesystem::directory_iterator files(Path("fits/cells"));
    return std::distance(begin(files), end(files));
  };
  for (int run = 0; run < 2; ++run) {
    const FitCellRun result = RunFitCells(job, cells, {});
    EXPECT_TRUE(result.done.empty());
    ASSERT_EQ(result.failures.size(), 2u);
    EXPECT_EQ(result.failures[0].name, "fabric_1");
    EXPECT_THAT(result.failures[0].reason, testing::HasSubstr("bad.jpg"));
    EXPECT_THAT(result.failures[1].reason, testing::HasSubstr("none.jpg"));
    EXPECT_EQ(stored(), 2);
  }
  Write("bad.jpg", "no image either");  // another cell, whose fit is tried
  RunFitCells(job, cells, {});
  EXPECT_EQ(stored(), 3);
  job.settings["mesh"] = "b";
  RunFitCells(job, cells, {});
  EXPECT_EQ(stored(), 5);
}

// A file in the place of the folder of a fit is no property of the fabric.
TEST_F(FabricFitsTest, ARefusalOfTheSystemIsNotRemembered) {
  FitCellJob job;
  job.material = Path("start.json");
  job.study.out = Path("fits");
  const std::vector<FitCell> cells =
      MakeFitCells({{1, 1, 1, ClothFace::kUp, Path("bad.jpg")}}, false);
  std::filesystem::create_directories(Path("fits"));
  Write("fits/fabric_1", "a file in the place of the folder of the fit");
  EXPECT_ANY_THROW(RunFitCells(job, cells, {}));
  EXPECT_FALSE(std::filesystem::exists(Path("fits/cells")));
}

// Fabrics recognised by predictions that are learned from fake drapes [METHODS, P62].

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
