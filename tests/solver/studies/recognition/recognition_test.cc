// SPDX-License-Identifier: Apache-2.0
// Cells and samples of recognition; fits that fail do not end a run [METHODS, P62].
#include "solver/studies/recognition/recognition.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "physics/material/material_io.h"
#include "physics/util/errors.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

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
  EXPECT_TRUE(std::filesystem::is_empty(Path("fits/cells")));
}

}  // namespace
}  // namespace drape::test
