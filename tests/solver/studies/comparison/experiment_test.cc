// SPDX-License-Identifier: Apache-2.0
// An experiment is computed once, resumes where it was stopped, and is computed again where it is
// broken.
#include "solver/studies/comparison/experiment.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/job/fit_captures.h"
#include "tests/losses/dataset/synthetic_dataset.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

class ExperimentTest : public FileFixture {
 protected:
  ExperimentTest() {
    for (int sample = 1; sample <= 3; ++sample)
      data_.AddImage("Fabric 2/silhouettes/Sample_" + std::to_string(sample) + "_Capture_1.jpg",
                     88 + sample, 4, 0.5 * sample);
    const auto captures = Select(ReadDataset(data_.path()), {});
    training_ = ObserveCaptures({captures[0]}, Camera());
    held_out_ = ObserveCaptures({captures[1], captures[2]}, Camera());
    WriteMaterial(Path("start.json"), {.name = "start",
                                       .field = test::TestMaterial(),
                                       .source_convention = "arcsim",
                                       .source = "",
                                       .warnings = {}});
    UseCaptures({captures[0]}, &task_.data);
    task_.data.material = Path("start.json");
    task_.fit.mesh = "disc:120";
    task_.fit.coarse_mesh = "disc:100";
    task_.fit.backend = "cpu";
    task_.fit.stages.grid.stretch = {1.0};
    task_.fit.stages.grid.bend = {4.0};
    task_.fit.stages.grid.lifts = {0.5, 1.0};
    task_.fit.stages.candidates_per_round = {2, 1};
    task_.fit.stages.iterations = {2, 2};
    task_.fit.observation.angles = 72;
    task_.fit.stages.parameters = ParameterTying::kScales;
    task_.prediction.specimens = 4;
    task_.prediction.settle.steps.steps = 60;
    task_.training = &training_;
    task_.held_out = &held_out_;
    task_.calibrate = false;
    task_.folder = Path("experiment");
    task_.checkpoint = Path("one_table.json");
  }
  bool Run(const std::atomic<bool>* cancel = nullptr) {
    notes_.clear();
    return RunExperiment(task_, {cancel, [&](double fraction, const std::string& note) {
                                   EXPECT_LE(fraction, 1.0);
                                   notes_ += note + " ";
                                   if (on_note_) on_note_(note);
                                 }});
  }
  std::string Text() const {
    nlohmann::json json = ReadJsonFile(Path("experiment/prediction.json"));
    json.erase("seconds");
    json.erase("checksum");
    for (const char* timed : {"prediction_seconds", "calibration_seconds"})
      json["numbers"].erase(timed);
    return json.dump() + Read(Path("experiment/material.json"));
  }

  const SyntheticDataset data_;
  std::vector<ObservedCapture> training_, held_out_;
  ExperimentTask task_;
  std::string notes_;
  std::function<void(const std::string&)> on_note_;
};

TEST_F(ExperimentTest, HasTheNumbersOfFitAndPrediction) {
  task_.calibrate = true;
  ASSERT_TRUE(Run());
  const auto experiment = ReadExperiment(Path("experiment"));
  ASSERT_TRUE(experiment);
  EXPECT_EQ(experiment->failure, "");
  for (const ComparedNumber& number : kComparedNumbers)
    EXPECT_EQ(experiment->numbers.contains(number.key), number.key != std::string("elbo"))
        << number.key;
  EXPECT_EQ(experiment->numbers.at("parameters"), 2);
  EXPECT_FALSE(experiment->belief);
  ASSERT_EQ(experiment->captures.size(), 2u);
  EXPECT_EQ(experiment->captures[1].sample, 3);
  EXPECT_NEAR(
      0.5 * (experiment->captures[0].feature_energy + experiment->captures[1].feature_energy),
      experiment->numbers.at("feature_energy"), 1e-12);
}

TEST_F(ExperimentTest, ABrokenFileIsMadeAnewAndTheSame) {
  ASSERT_TRUE(Run());
  const std::string whole = Text();
  ASSERT_TRUE(ReadExperiment(Path("experiment")));
  Write("experiment/prediction.json", Read(Path("experiment/prediction.json")).substr(0, 50));
  EXPECT_FALSE(ReadExperiment(Path("experiment")));
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_,
              testing::Not(testing::HasSubstr("initial guesses")));  // the fit is taken over
  EXPECT_EQ(Text(), whole);
  Write("experiment/material.json", "{");
  Write("one_table.json", "{");
  EXPECT_FALSE(ReadExperiment(Path("experiment")));
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::HasSubstr("round"));
  EXPECT_EQ(Text(), whole);
  for (const char* damage : {"/captures", "/numbers"}) {
    nlohmann::json prediction = nlohmann::json::parse(Read(Path("experiment/prediction.json")));
    const nlohmann::json::json_pointer at(damage);
    prediction[at] = nlohmann::json(prediction[at].type());  // empty
    const StoredFormat format = {"drapefit-prediction", prediction["version"]};
    for (const char* key : {"format", "version", "checksum"}) prediction.erase(key);
    WriteStoredJson(Path("experiment/prediction.json"), format, prediction);
    EXPECT_FALSE(ReadExperiment(Path("experiment"))) << damage;
    ASSERT_TRUE(Run());
    EXPECT_EQ(Text(), whole);
  }
  nlohmann::json summary = nlohmann::json::parse(Read(Path("experiment/summary.json")));
  summary["mean"] = nlohmann::json::array();
  Write("experiment/summary.json", summary.dump());
  EXPECT_FALSE(ReadExperiment(Path("experiment")));
  ASSERT_TRUE(Run());
  EXPECT_EQ(Text(), whole);
  std::filesystem::remove(Path("experiment/summary.json"));
  EXPECT_FALSE(ReadExperiment(Path("experiment")));
}

TEST_F(ExperimentTest, GoesOnAfterACancelToTheSameNumbers) {
  task_.calibrate = true;
  ASSERT_TRUE(Run());
  const std::string whole = Text();
  std::filesystem::remove_all(Path("experiment"));
  std::filesystem::remove(Path("one_table.json"));
  for (const std::string stage : {"round 1", "prediction", "calibration"}) {
    std::atomic<bool> cancel = false;
    on_note_ = [&](const std::string& note) { cancel = cancel || note == stage; };
    EXPECT_FALSE(Run(&cancel)) << stage;
    EXPECT_FALSE(ReadExperiment(Path("experiment"))) << stage;
  }
  on_note_ = {};
  ASSERT_TRUE(Run());
  EXPECT_EQ(Text(), whole);
}

TEST_F(ExperimentTest, ACalibrationKeepsTheScoresOfTheFitAsItIs) {
  ASSERT_TRUE(Run());
  const Numbers as_fitted = ReadExperiment(Path("experiment"))->numbers;
  EXPECT_FALSE(as_fitted.contains("bend_factor_up"));
  EXPECT_FALSE(as_fitted.contains("dc_error_as_fitted"));
  task_.calibrate = true;
  training_ = {
      {training_[0].capture, ObserveDisc(0.1, Camera(), {})}};  // hangs far lower than the fit
  nlohmann::json earlier = ReadJsonFile(Path("experiment/prediction.json"));
  earlier["version"] = 2;
  Write("experiment/prediction.json", earlier.dump());
  EXPECT_FALSE(ReadExperiment(Path("experiment")));
  ASSERT_TRUE(Run());
  const Numbers calibrated = ReadExperiment(Path("experiment"))->numbers;
  for (const std::string key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    EXPECT_EQ(calibrated.at(key + "_as_fitted"), as_fitted.at(key)) << key;
  EXPECT_EQ(calibrated.at("bend_factor_up"), calibrated.at("bend_factor_down"));  // not known
  EXPECT_LT(calibrated.at("bend_factor_up"), 1);
  EXPECT_NE(calibrated.at("feature_energy"), as_fitted.at("feature_energy"));
}

TEST_F(ExperimentTest, ModelsGoOnFromTheSameTable) {
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::HasSubstr("initial guesses"));
  const nlohmann::json table = ReadJsonFile(Path("experiment/material.json"));
  task_.folder = Path("fields");
  task_.fit.model = FitModel::kHeterogeneous;
  task_.fit.fields.iterations = 1;
  task_.fit.fields.restarts = 0;
  ASSERT_TRUE(Run());
  EXPECT_THAT(notes_, testing::Not(testing::HasSubstr("initial guesses")));
  EXPECT_THAT(notes_, testing::HasSubstr("fields"));
  EXPECT_EQ(ReadJsonFile(Path("fields/material_homogeneous.json"))["stretch"], table["stretch"]);
}

TEST_F(ExperimentTest, SamplesThatDoNotComeToRestFailWithAReason) {
  task_.prediction.settle.equilibrium.tolerance = 1e-30;
  ASSERT_TRUE(Run());
  const auto experiment = ReadExperiment(Path("experiment"));
  ASSERT_TRUE(experiment);
  EXPECT_THAT(experiment->failure, testing::HasSubstr("fewer than two draws at rest"));
  EXPECT_TRUE(experiment->captures.empty());
}

// Of a model that stayed at its one table there is no prediction: it would be that of homogeneous.
TEST_F(ExperimentTest, AModelThatCouldNotBeFittedHasNoScore) {
  ASSERT_TRUE(Run());
  std::filesystem::remove(Path("experiment/prediction.json"));
  task_.fit.model = FitModel::kHeterogeneous;
  ASSERT_TRUE(Run());
  EXPECT_EQ(ReadExperiment(Path("experiment"))->failure, "the fields could not be fitted");
}

}  // namespace
}  // namespace drape
