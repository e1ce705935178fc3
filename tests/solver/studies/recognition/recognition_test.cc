// SPDX-License-Identifier: Apache-2.0
// Which fabric a sample is of, from made-up samples; fits that fail do not end a run
// [METHODS, P62].
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <filesystem>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "solver/posterior/variational/gaussian_posterior.h"
#include "solver/studies/recognition/fabric_fits.h"
#include "solver/studies/recognition/recognition_scores.h"
#include "solver/studies/recognition/sample_list.h"
#include "solver/studies/recognition/sample_model.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape::test {
namespace {

constexpr int kFabrics = 6, kSamples = 40;
const Eigen::Matrix2d kWithin = (Eigen::Matrix2d() << 0.5, 0.2, 0.2, 0.3).finished();

// Samples of fabrics on a line, seen with noise.
std::vector<SeenSample> DrawSamples(double noise) {
  const Eigen::MatrixXd standard = IndependentSamples(4, kFabrics * kSamples, 2);
  const Eigen::Matrix2d root = kWithin.llt().matrixL();
  std::vector<SeenSample> samples;
  for (int i = 0; i < kFabrics * kSamples; ++i) {
    const int fabric = i % kFabrics;
    const Eigen::Vector2d x = Eigen::Vector2d(2.0 * fabric, 0.0) +
                              root * standard.col(i).head<2>() + noise * standard.col(i).tail<2>();
    samples.push_back({fabric, {x, noise * noise * Eigen::Matrix2d::Identity()}});
  }
  return samples;
}

TEST(SampleModel, SeparatesTheScatterOfSamplesFromNoise) {
  const SampleModel model(DrawSamples(0.5), kFabrics, Eigen::Vector2d::Constant(0.5));
  EXPECT_LT((model.within() - kWithin).norm(), 0.12);
  for (int f = 0; f < kFabrics; ++f) {
    EXPECT_LT((model.fabric(f).mean - Eigen::Vector2d(2.0 * f, 0.0)).norm(), 0.4) << f;
    EXPECT_LT(model.fabric(f).covariance(0, 0), 0.05) << f;
  }
  const NormalDistribution seen{Eigen::Vector2d(4.1, 0.1), 0.01 * Eigen::Matrix2d::Identity()};
  int best = 0;
  model.LogLikelihoods(seen).maxCoeff(&best);
  EXPECT_EQ(best, 2);
}

TEST(SampleModel, AFabricWithoutSamplesIsAsThePopulation) {
  std::vector<SeenSample> samples = DrawSamples(0.1);
  std::erase_if(samples, [](const SeenSample& sample) { return sample.fabric == 5; });
  const SampleModel model(samples, kFabrics, Eigen::Vector2d::Constant(0.5));
  EXPECT_GT(model.fabric(5).covariance(0, 0), 2.0);
}

TEST(SampleModel, ComparesEachSampleWithTheOthersAlone) {
  std::vector<SeenSample> samples = DrawSamples(0.1);
  samples.resize(12);
  const Eigen::Vector2d scale = Eigen::Vector2d::Constant(0.5);
  const std::vector<SeenSample> others(samples.begin() + 1, samples.end());
  EXPECT_EQ(CompareWithOthers(samples, kFabrics, scale)[0],
            SampleModel(others, kFabrics, scale).LogLikelihoods(samples[0].seen));
}

RecognisedSample Recognised(int fabric, const std::string& way, const Eigen::VectorXd& logs) {
  return {"sample", fabric, {{way, logs}}};
}

TEST(RecognitionScores, CountsRanksAndLosses) {
  const Eigen::Vector4d logs(std::log(0.1), std::log(0.45), std::log(0.25), std::log(0.2));
  const std::vector<RecognisedSample> samples = {
      Recognised(1, "way", logs), Recognised(3, "way", (logs.array() + 7).matrix()),
      Recognised(0, "way", logs), Recognised(0, "other", logs)};
  const RecognitionScore score = ScoreWay(samples, "way", 4);
  EXPECT_EQ(score.samples, 3);
  EXPECT_DOUBLE_EQ(score.top_1, 1.0 / 3);
  EXPECT_DOUBLE_EQ(score.top_3, 2.0 / 3);
  EXPECT_NEAR(score.log_loss, -(std::log(0.45) + std::log(0.2) + std::log(0.1)) / 3, 1e-12);
  EXPECT_EQ(score.confusion(3, 1), 1);
  EXPECT_EQ(score.confusion(1, 1), 1);
  EXPECT_DOUBLE_EQ(score.reliability(2, 0), 3.0);
  EXPECT_NEAR(score.reliability(2, 1), 0.45, 1e-12);
  EXPECT_DOUBLE_EQ(score.reliability(2, 2), 1.0 / 3);
  EXPECT_THAT(RecognitionText({score}, {"a", "b", "c", "d"}), testing::HasSubstr("| d | 0 of 1 |"));
}

// A way that is right and one that is noise: the product is the first; two halves of what there is
// to know are better together.
TEST(RecognitionScores, AProductTakesWhatHelps) {
  std::vector<RecognisedSample> samples;
  std::mt19937_64 random(3);
  for (int i = 0; i < 120; ++i) {
    const int fabric = i % 4;
    Eigen::VectorXd half(4), other(4), noise(4);
    for (int f = 0; f < 4; ++f) {
      half[f] = (f / 2 == fabric / 2 ? 2.0 : 0.0) + 0.5 * SampleNormal(random);
      other[f] = (f % 2 == fabric % 2 ? 2.0 : 0.0) + 0.5 * SampleNormal(random);
      noise[f] = 8.0 * SampleNormal(random);
    }
    samples.push_back({"s", fabric, {{"half", half}, {"other", other}, {"noise", noise}}});
  }
  AddProduct("both", {"half", "other"}, &samples);
  AddProduct("with noise", {"half", "noise"}, &samples);
  const double half = ScoreWay(samples, "half", 4).log_loss;
  EXPECT_LT(ScoreWay(samples, "both", 4).log_loss, 0.6 * half);
  EXPECT_GT(ScoreWay(samples, "both", 4).top_1, 0.8);
  EXPECT_LT(ScoreWay(samples, "with noise", 4).log_loss, half + 0.02);
  EXPECT_GT(ScoreWay(samples, "noise", 4).log_loss, 2.0);
}

// Sample 0 counts for its own weights neither where they help it nor where they harm.
TEST(RecognitionScores, WeightsOfASampleComeFromTheOthers) {
  const auto product = [](int fabric) {
    std::vector<RecognisedSample> samples = {Recognised(fabric, "way", Eigen::Vector2d(3, 0)),
                                             Recognised(0, "way", Eigen::Vector2d(1, 0))};
    AddProduct("product", {"way"}, &samples);
    return samples[0].by_way.at("product");
  };
  EXPECT_EQ(product(0), product(1));
  EXPECT_LT(product(1)[1], -10.0);  // the other sample is right, so that it is sure
}

class FabricFitsTest : public FileFixture {};

TEST_F(FabricFitsTest, CellsAreByFabricOrBySample) {
  const std::vector<Capture> captures = {{1, 1, 1}, {1, 1, 2}, {1, 2, 1}, {4, 2, 1}};
  const std::vector<FitCell> fabrics = CellsByFabric(captures), samples = CellsBySample(captures);
  ASSERT_EQ(fabrics.size(), 2u);
  EXPECT_EQ(fabrics[0].name, "fabric_1");
  EXPECT_EQ(fabrics[0].captures.size(), 3u);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[2].name, "fabric_4/sample_2");
}

TEST_F(FabricFitsTest, AFabricWithOneSampleIsNotRecognised) {
  const std::vector<Capture> captures = {{1, 1, 1}, {1, 2, 1}, {2, 1, 1},
                                         {4, 2, 1}, {4, 5, 1}, {4, 5, 2}};
  const std::vector<FitCell> cells = CellsBySample(captures);
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
  job.out = Path("");
  job.threads = 2;
  job.fit.model = FitModel::kBayes;
  job.settings = {{"mesh", "a"}};
  const std::vector<FitCell> cells = CellsByFabric(
      {{1, 1, 1, ClothFace::kUp, Path("bad.jpg")}, {2, 1, 1, ClothFace::kUp, Path("none.jpg")}});
  for (int run = 0; run < 2; ++run) {
    const FitCellRun result = RunFitCells(job, cells, {});
    EXPECT_TRUE(result.done.empty());
    ASSERT_EQ(result.failures.size(), 2u);
    EXPECT_EQ(result.failures[0].name, "fabric_1");
    EXPECT_THAT(result.failures[0].reason, testing::HasSubstr("bad.jpg"));
    EXPECT_THAT(result.failures[1].reason, testing::HasSubstr("none.jpg"));
    EXPECT_TRUE(std::filesystem::exists(Path("fabric_2/failure.json")));
  }
  job.settings["mesh"] = "b";
  EXPECT_THROW(RunFitCells(job, cells, {}), InputError);
}

}  // namespace
}  // namespace drape::test
