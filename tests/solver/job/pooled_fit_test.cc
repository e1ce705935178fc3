// SPDX-License-Identifier: Apache-2.0
// Fits that start from the shipped pool.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/util/atomic_file.h"
#include "solver/fit/effective_stiffness.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape {
namespace {

class PooledFitTest : public test::FitJobTest {
 protected:
  PooledFitTest() {
    spec_.simpler_models = true;
    spec_.stages.grid = {};
    spec_.stages.candidates_per_round = {3, 2, 1};
    spec_.stages.iterations = {3, 3, 8};
  }
};

TEST_F(PooledFitTest, FindsTheFabricWhateverTheStartTablesAre) {
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json summary = Summary();
  EXPECT_GE(summary["initial_guess"]["pooled_drape"], 1);
  EXPECT_LT(summary["images"][0]["metrics"]["profile_rms_px"].get<double>(), 1.5);
  const double reference = MeanBend(Scaled(test::TestMaterial(), 1.0, 4.0).bend[0]),
               fitted = summary["stiffness"]["bend_n_m"]["fitted"];
  EXPECT_LT(std::abs(std::log(fitted / reference)), std::log(1.6));
  const std::string name = summary["images"][0]["name"];
  const nlohmann::json length = summary["laboratory"]["at_once_" + name]["rows"][2];
  EXPECT_EQ(length["key"], "bending_length_overall_cm");
  const double known = 100 * BendingLength(reference, test::TestMaterial().density);
  EXPECT_LT(length["low"].get<double>(), known);
  EXPECT_GT(length["low"].get<double>(), 0.5 * known);
  const std::vector<uint8_t> material = ReadAll(folder_ / "material.json");
  WriteStart(Scaled(test::TestMaterial(), 30.0, 0.1));
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  EXPECT_EQ(ReadAll(folder_ / "material.json"), material);
}

// The fabric is stiffer than pooled ones, so its rigidity has a lower end alone: that of all
// branches, which the result's tables do not say.
TEST_F(PooledFitTest, TheSheetCountsAllBranches) {
  WriteStart(Scaled(test::TestMaterial(), 1.0, 4.0));
  data_.ground_truth = data_.material;
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json summary = Summary();
  const auto row = [&](const char* sheet) {
    for (const nlohmann::json& each : summary["laboratory"][sheet]["rows"])
      if (each["key"] == "bending_in_drape_un_m") return each;
    return nlohmann::json();
  };
  const double known = row("reference")["value"], low = row("material")["low"];
  EXPECT_NEAR(known, 1e6 * summary["stiffness"]["bend_n_m"]["reference"].get<double>(), 1e-9);
  EXPECT_LT(low, known);
  EXPECT_GT(low, 0.3 * known);
  const double in_tables = 1e6 * summary["stiffness"]["bend_n_m"]["fitted"].get<double>();
  EXPECT_GT(std::abs(std::log(low / in_tables) + kQuantile90 * kBranchDeviation), 1e-2);
}

TEST_F(PooledFitTest, AMirrorImageHasTheSameFit) {
  spec_.stages.iterations = {2, 2, 2};
  const auto bend = [&] {
    RunFitJob(spec_, data_, files_, {});
    const MaterialField field = ReadMaterial(folder_ / "material.json").field;
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(field.bend[0].entries(), kBendEntries));
  };
  const Eigen::VectorXd plain = bend();
  data_.images.clear();
  AddImage("b.png", test::QuarterTurned(DrapeImage(), 0, true));
  EXPECT_LT((bend().array() / plain.array()).log().abs().maxCoeff(), 1e-5);
}

TEST_F(PooledFitTest, GoesOnAfterACancelToTheSameFiles) {
  RunFitJob(spec_, data_, files_, {});
  const std::vector<uint8_t> whole = ReadAll(folder_ / "material.json");
  const nlohmann::json sheet = Summary()["laboratory"]["material"];
  for (const char* stage : {"linear, 7 numbers, round 1", "round 1", "round 2"}) {
    std::atomic<bool> cancel = false;
    const RunControl control = {&cancel, [&](double, const std::string& note) {
                                  if (note.starts_with(stage)) cancel = true;
                                }};
    EXPECT_TRUE(RunFitJob(spec_, data_, files_, control).cancelled) << stage;
    files_.resume = true;
    EXPECT_FALSE(RunFitJob(spec_, data_, files_, {}).cancelled);
    files_.resume = false;
    EXPECT_EQ(ReadAll(folder_ / "material.json"), whole) << stage;
    EXPECT_EQ(Summary()["laboratory"]["material"], sheet) << stage;
  }
}

// The start tables hold part of what is fitted there, or a user has said how to search.
TEST_F(PooledFitTest, OtherFitsStartFromTheirTables) {
  const auto is_pooled = [&](const std::function<void(FitSpec&)>& change) {
    FitSpec spec = spec_;
    spec.stages.candidates_per_round = {1};
    spec.stages.iterations = {0};
    spec.simpler_models = false;
    change(spec);
    EXPECT_TRUE(RunFitJob(spec, data_, files_, {}).fitted);
    return Summary()["initial_guess"].contains("pooled_drape");
  };
  EXPECT_TRUE(is_pooled([](FitSpec&) {}));
  EXPECT_GE(Summary()["rollouts"], 6);  // two tables from three lifts
  const auto quick = [](FitSpec& spec) { spec.stages.grid.bend = {4.0}; };
  EXPECT_FALSE(is_pooled(quick));
  spec_.stages.grid.steps = 5;
  EXPECT_FALSE(is_pooled([](FitSpec& spec) { spec.start_pool = false; }));
  EXPECT_FALSE(is_pooled([](FitSpec& spec) { spec.stages.parameters = ParameterTying::kScales; }));
  EXPECT_FALSE(is_pooled([](FitSpec& spec) { spec.law = LawKind::kReference; }));
  spec_.table_form = TableForm::kIsotropic;
  EXPECT_TRUE(is_pooled([](FitSpec& spec) { spec.stages.parameters = ParameterTying::kScales; }));
}

}  // namespace
}  // namespace drape
