// SPDX-License-Identifier: Apache-2.0
// A cell is computed once, goes on where it was stopped, and is computed anew where it is broken.
#include "solver/comparison_cell.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/atomic_file.h"
#include "physics/json_input.h"
#include "physics/material_io.h"
#include "solver/fit_captures.h"
#include "tests/losses/synthetic_dataset.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

class ComparisonCellTest : public FileFixture {
 protected:
  ComparisonCellTest() {
    for (int sample = 1; sample <= 3; ++sample)
      data_.AddImage("Fabric 2/silhouettes/Sample_" + std::to_string(sample) + "_Capture_1.jpg",
                     88 + sample, 4, 0.5 * sample);
    const auto captures = Select(ReadDataset(data_.path()), {});
    learnt_ = SeeCaptures({captures[0]}, Camera());
    held_out_ = SeeCaptures({captures[1], captures[2]}, Camera());
    WriteMaterial(Path("start.json"), {.name = "start",
                                       .field = test::TestMaterial(),
                                       .source_convention = "arcsim",
                                       .source = "",
                                       .warnings = {}});
    UseCaptures({captures[0]}, &task_.fit);
    task_.fit.material = Path("start.json");
    task_.fit.mesh = "disc:120";
    task_.fit.coarse_mesh = "disc:100";
    task_.fit.backend = "cpu";
    task_.fit.evaluation_steps = 5;
    task_.fit.fit.grid.stretch = {1.0};
    task_.fit.fit.grid.bend = {4.0};
    task_.fit.fit.grid.lifts = {0.5, 1.0};
    task_.fit.fit.keep = {2, 1};
    task_.fit.fit.iterations = {2, 2};
    task_.fit.fit.angles = 72;
    task_.fit.fit.parameters = Tying::kScales;
    task_.prediction.specimens = 4;
    task_.prediction.settle.steps.steps = 60;
    task_.learnt = &learnt_;
    task_.held_out = &held_out_;
    task_.calibrate = false;
    task_.folder = Path("cell");
    task_.fit.checkpoint = Path("one_table.json");
  }
  bool Run(const std::atomic<bool>* cancel = nullptr) {
    notes_.clear();
    return RunCell(task_, {cancel, [&](double fraction, const std::string& note) {
                             EXPECT_LE(fraction, 1.0);
                             notes_ += note + " ";
                             if (on_note_) on_note_(note);
                           }});
  }
  std::string Text() const {
    nlohmann::json json = ReadJsonFile(Path("cell/prediction.json"));
    json.erase("seconds");
    for (const char* timed : {"prediction_seconds", "calibration_seconds"})
      json["numbers"].erase(timed);
    return json.dump() + Read(Path("cell/material.json"));
  }

  const SyntheticDataset data_;
  std::vector<SeenCapture> learnt_, held_out_;
  CellTask task_;
  std::string notes_;
  std::function<void(const std::string&)> on_note_;
};

TEST_F(ComparisonCellTest, HasTheNumbersOfFitAndPrediction) {
  task_.calibrate = true;
  ASSERT_TRUE(Run());
  const auto cell = ReadCell(Path("cell"));
  ASSERT_TRUE(cell);
  EXPECT_EQ(cell->failure, "");
  for (const ComparedNumber& number : kComparedNumbers)
    EXPECT_EQ(cell->numbers.contains(number.key), number.key != std::string("elbo")) << number.key;
  EXPECT_EQ(cell->numbers.at("parameters"), 2);
  EXPECT_FALSE(cell->belief);
  ASSERT_EQ(cell->captures.size(), 2u);
  EXPECT_EQ(cell->captures[1].sample, 3);
  EXPECT_NEAR(0.5 * (cell->captures[0].feature_energy + cell->captures[1].feature_energy),
              cell->numbers.at("feature_energy"), 1e-12);
}

TEST_F(ComparisonCellTest, ABrokenFileIsMadeAnewAndTheSame) {
  ASSERT_TRUE(Run());
  const std::string whole = Text();
  ASSERT_TRUE(ReadCell(Path("cell")));
  Write("cell/prediction.json", Read(Path("cell/prediction.json")).substr(0, 50));
  EXPECT_FALSE(ReadCell(Path("cell")));
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::Not(testing::HasSubstr("grid")));  // the fit is taken over
  EXPECT_EQ(Text(), whole);
  Write("cell/material.json", "{");
  Write("one_table.json", "{");
  EXPECT_FALSE(ReadCell(Path("cell")));
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::HasSubstr("round"));
  EXPECT_EQ(Text(), whole);
  std::filesystem::remove(Path("cell/summary.json"));
  EXPECT_FALSE(ReadCell(Path("cell")));
}

TEST_F(ComparisonCellTest, GoesOnAfterACancelToTheSameNumbers) {
  task_.calibrate = true;
  ASSERT_TRUE(Run());
  const std::string whole = Text();
  std::filesystem::remove_all(Path("cell"));
  std::filesystem::remove(Path("one_table.json"));
  for (const std::string stage : {"round 1", "prediction", "calibration"}) {
    std::atomic<bool> cancel = false;
    on_note_ = [&](const std::string& note) { cancel = cancel || note == stage; };
    EXPECT_FALSE(Run(&cancel)) << stage;
    EXPECT_FALSE(ReadCell(Path("cell"))) << stage;
  }
  on_note_ = {};
  ASSERT_TRUE(Run());
  EXPECT_EQ(Text(), whole);
}

TEST_F(ComparisonCellTest, ACalibrationKeepsTheScoresOfTheFitAsItIs) {
  ASSERT_TRUE(Run());
  const Numbers as_fitted = ReadCell(Path("cell"))->numbers;
  EXPECT_FALSE(as_fitted.contains("bend_factor_up"));
  EXPECT_FALSE(as_fitted.contains("dc_error_as_fitted"));
  task_.calibrate = true;
  learnt_ = {{learnt_[0].capture, SeeDisc(0.1, Camera())}};  // hangs far lower than the fit
  nlohmann::json earlier = ReadJsonFile(Path("cell/prediction.json"));
  earlier["version"] = 2;
  Write("cell/prediction.json", earlier.dump());
  EXPECT_FALSE(ReadCell(Path("cell")));
  ASSERT_TRUE(Run());
  const Numbers calibrated = ReadCell(Path("cell"))->numbers;
  for (const std::string key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    EXPECT_EQ(calibrated.at(key + "_as_fitted"), as_fitted.at(key)) << key;
  EXPECT_EQ(calibrated.at("bend_factor_up"), calibrated.at("bend_factor_down"));  // not known
  EXPECT_LT(calibrated.at("bend_factor_up"), 1);
  EXPECT_NE(calibrated.at("feature_energy"), as_fitted.at("feature_energy"));
}

TEST_F(ComparisonCellTest, ModelsGoOnFromTheSameTable) {
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::HasSubstr("grid"));
  const nlohmann::json table = ReadJsonFile(Path("cell/material.json"));
  task_.folder = Path("fields");
  task_.fit.model = "heter";
  task_.fit.fields.iterations = 1;
  task_.fit.fields.hops = 0;
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::Not(testing::HasSubstr("grid")));
  EXPECT_THAT(notes_, testing::HasSubstr("fields"));
  EXPECT_EQ(ReadJsonFile(Path("fields/material_homo.json"))["stretch"], table["stretch"]);
}

TEST_F(ComparisonCellTest, DrawsThatDoNotComeToRestAreACellWithAReason) {
  task_.prediction.settle.equilibrium.tolerance = 1e-30;
  ASSERT_TRUE(Run());
  const auto cell = ReadCell(Path("cell"));
  ASSERT_TRUE(cell);
  EXPECT_THAT(cell->failure, testing::HasSubstr("fewer than two draws at rest"));
  EXPECT_TRUE(cell->captures.empty());
}

// Of a model that stayed at its one table there is no prediction: it would be that of homo.
TEST_F(ComparisonCellTest, AModelThatCouldNotBeFittedHasNoScore) {
  ASSERT_TRUE(Run());
  std::filesystem::remove(Path("cell/prediction.json"));
  task_.fit.model = "heter";
  ASSERT_TRUE(Run());
  EXPECT_EQ(ReadCell(Path("cell"))->failure, "the fields could not be fitted");
}

}  // namespace
}  // namespace drape
