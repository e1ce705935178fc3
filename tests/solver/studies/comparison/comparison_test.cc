// SPDX-License-Identifier: Apache-2.0
// A run resumes where it was stopped, and begins again where its checkpoint is damaged.
#include "solver/studies/comparison/comparison.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/util/json_input.h"
#include "solver/job/fit_input.h"
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
  // Nothing when cancelled.
  std::optional<nlohmann::json> Run(const std::atomic<bool>* cancel = nullptr) {
    notes_.clear();
    return RunExperiment(task_, {cancel, [&](double fraction, const std::string& note) {
                                   EXPECT_LE(fraction, 1.0);
                                   notes_ += note + " ";
                                   if (on_note_) on_note_(note);
                                 }});
  }
  std::string Text(nlohmann::json result) const {
    for (const char* timed : {"fit_seconds", "prediction_seconds", "calibration_seconds"})
      result["numbers"].erase(timed);
    return result.dump() + Read(Path("experiment/material.json"));
  }

  const SyntheticDataset data_;
  std::vector<ObservedCapture> training_, held_out_;
  ExperimentTask task_;
  std::string notes_;
  std::function<void(const std::string&)> on_note_;
};

TEST_F(ExperimentTest, HasTheNumbersOfFitAndPrediction) {
  task_.calibrate = true;
  const nlohmann::json result = Run().value();
  EXPECT_FALSE(result.contains("failure"));
  EXPECT_FALSE(result.contains("posterior"));
  const nlohmann::json& numbers = result["numbers"];
  for (const char* key : {"train_mse",
                          "train_profile_rms_px",
                          "train_iou",
                          "train_hausdorff_m",
                          "mean_image_mse",
                          "dc_error",
                          "dc_crps",
                          "dc_coverage_50",
                          "dc_width_50",
                          "dc_coverage_90",
                          "dc_width_90",
                          "folds_error",
                          "folds_crps",
                          "folds_coverage_50",
                          "folds_width_50",
                          "folds_coverage_90",
                          "folds_width_90",
                          "feature_energy",
                          "outline_energy_m",
                          "hausdorff_m",
                          "bend_factor_up",
                          "bend_factor_down",
                          "mean_image_mse_as_fitted",
                          "dc_error_as_fitted",
                          "dc_coverage_90_as_fitted",
                          "feature_energy_as_fitted",
                          "fit_seconds",
                          "calibration_seconds",
                          "prediction_seconds",
                          "rollouts"})
    EXPECT_TRUE(numbers.contains(key)) << key;
  EXPECT_EQ(numbers["parameters"], 2);
  const nlohmann::json& captures = result["captures"];
  ASSERT_EQ(captures.size(), 2u);
  EXPECT_EQ(captures[1]["sample"], 3);
  EXPECT_NEAR(0.5 * (captures[0]["feature_energy"].get<double>() +
                     captures[1]["feature_energy"].get<double>()),
              numbers["feature_energy"].get<double>(), 1e-12);
}

TEST_F(ExperimentTest, ADamagedCheckpointIsMadeAnewAndTheSame) {
  const std::string whole = Text(Run().value());
  const std::string again = Text(Run().value());
  EXPECT_THAT(notes_, testing::Not(testing::HasSubstr("initial guesses")));  // from the checkpoint
  EXPECT_EQ(again, whole);
  Write("one_table.json", "{");
  Write("experiment/summary.json", "{");
  const std::string repeated = Text(Run().value());
  EXPECT_THAT(notes_, testing::HasSubstr("initial guesses"));
  EXPECT_EQ(repeated, whole);
}

TEST_F(ExperimentTest, GoesOnAfterACancelToTheSameNumbers) {
  task_.calibrate = true;
  const std::string whole = Text(Run().value());
  std::filesystem::remove_all(Path("experiment"));
  std::filesystem::remove(Path("one_table.json"));
  for (const std::string stage : {"round 1", "prediction", "calibration"}) {
    std::atomic<bool> cancel = false;
    on_note_ = [&](const std::string& note) { cancel = cancel || note == stage; };
    EXPECT_FALSE(Run(&cancel).has_value()) << stage;
  }
  on_note_ = {};
  EXPECT_EQ(Text(Run().value()), whole);
}

TEST_F(ExperimentTest, ACalibrationKeepsTheScoresOfTheFitAsItIs) {
  const nlohmann::json as_fitted = Run().value()["numbers"];
  EXPECT_FALSE(as_fitted.contains("bend_factor_up"));
  EXPECT_FALSE(as_fitted.contains("dc_error_as_fitted"));
  task_.calibrate = true;
  training_ = {
      {training_[0].capture, ObserveDisc(0.1, Camera(), {})}};  // hangs far lower than the fit
  const nlohmann::json calibrated = Run().value()["numbers"];
  for (const std::string key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    EXPECT_EQ(calibrated.at(key + "_as_fitted"), as_fitted.at(key)) << key;
  EXPECT_EQ(calibrated.at("bend_factor_up"), calibrated.at("bend_factor_down"));  // not known
  EXPECT_LT(calibrated.at("bend_factor_up"), 1);
  EXPECT_NE(calibrated.at("feature_energy"), as_fitted.at("feature_energy"));
}

TEST_F(ExperimentTest, ModelsGoOnFromTheSameTable) {
  ASSERT_TRUE(Run().has_value());
  EXPECT_THAT(notes_, testing::HasSubstr("initial guesses"));
  const nlohmann::json table = ReadJsonFile(Path("experiment/material.json"));
  task_.folder = Path("fields");
  task_.fit.model = FitModel::kHeterogeneous;
  task_.fit.fields.iterations = 1;
  task_.fit.fields.restarts = 0;
  ASSERT_TRUE(Run().has_value());
  EXPECT_THAT(notes_, testing::Not(testing::HasSubstr("initial guesses")));
  EXPECT_THAT(notes_, testing::HasSubstr("fields"));
  EXPECT_EQ(ReadJsonFile(Path("fields/material_homogeneous.json"))["stretch"], table["stretch"]);
}

TEST_F(ExperimentTest, SamplesThatDoNotComeToRestFailWithAReason) {
  task_.prediction.settle.equilibrium.tolerance = 1e-30;
  task_.prediction.settle.equilibrium.max_iterations = 3;
  const nlohmann::json result = Run().value();
  EXPECT_THAT(result["failure"].get<std::string>(),
              testing::HasSubstr("fewer than two draws at rest"));
  EXPECT_FALSE(result.contains("captures"));
  EXPECT_FALSE(result.contains("numbers"));
}

TEST(SummariseFit, ReadsASummary) {
  nlohmann::json summary = nlohmann::json::parse(R"({
      "mean": {"mse": 0.01, "profile_rms_px": 2, "iou": 0.9, "outline_hausdorff_m": 0.005},
      "seconds": {"grid": 1, "fit": 2, "report": 0.5}, "rollouts": 100,
      "parameters": {"count": 39},
      "posterior": {"kind": "hierarchy", "seconds": [4, 5], "rollouts": 50, "elbo": null,
                    "log_factors": [1, 2, 3], "stretch_n_per_m": [500, 20],
                    "bend_n_m": [1e-6, 1e-7]}})");
  const nlohmann::json result = SummariseFit(summary, FitModel::kBayes);
  EXPECT_EQ(result["numbers"]["fit_seconds"], 12.5);
  EXPECT_EQ(result["numbers"]["rollouts"], 150);
  EXPECT_EQ(result["numbers"]["parameters"], 3);
  EXPECT_FALSE(result["numbers"].contains("elbo"));
  EXPECT_EQ(result["posterior"]["bend_n_m"][1], 1e-7);
  summary["posterior"]["kind"] = "bdp";  // a mean and a deviation each
  EXPECT_EQ(SummariseFit(summary, FitModel::kBdp)["numbers"]["parameters"], 6);
}

// The one table of a model that could not be fitted would be scored as that of homogeneous.
TEST(SummariseFit, SaysWhichPartIsMissing) {
  const nlohmann::json table = {{"mean", nlohmann::json::object()}};
  EXPECT_EQ(SummariseFit(table, FitModel::kHeterogeneous)["failure"],
            "the fields could not be fitted");
  EXPECT_EQ(SummariseFit(table, FitModel::kBdp)["failure"], "the posterior could not be fitted");
  EXPECT_EQ(SummariseFit({{"status", "done"}}, FitModel::kHomogeneous)["failure"],
            "nothing could be fitted");
}

}  // namespace
}  // namespace drape
