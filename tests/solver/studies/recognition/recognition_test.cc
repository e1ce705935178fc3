// SPDX-License-Identifier: Apache-2.0
// Which fabric a sample is of, from made-up samples; fits that fail do not end a run
// [METHODS, P62].
#include "solver/studies/recognition/recognition.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <filesystem>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "solver/posterior/variational_fit.h"
#include "solver/studies/recognition/fit_cells.h"
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
  job.out = job.study.out = Path("fits");
  job.study.threads = 2;
  job.fit.model = FitModel::kBayes;
  job.settings = {{"mesh", "a"}};
  const std::vector<FitCell> cells = CellsByFabric(
      {{1, 1, 1, ClothFace::kUp, Path("bad.jpg")}, {2, 1, 1, ClothFace::kUp, Path("none.jpg")}});
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
  job.out = job.study.out = Path("fits");
  const std::vector<FitCell> cells = CellsByFabric({{1, 1, 1, ClothFace::kUp, Path("bad.jpg")}});
  std::filesystem::create_directories(Path("fits"));
  Write("fits/fabric_1", "a file in the place of the folder of the fit");
  EXPECT_ANY_THROW(RunFitCells(job, cells, {}));
  EXPECT_TRUE(std::filesystem::is_empty(Path("fits/cells")));
}

}  // namespace
}  // namespace drape::test
