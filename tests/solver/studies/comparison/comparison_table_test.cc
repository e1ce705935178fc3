// SPDX-License-Identifier: Apache-2.0
// Experiments summed up, chosen from and written.
#include "solver/studies/comparison/comparison_table.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/json_input.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::HasSubstr;
using testing::Not;

ComparedExperiment MakeExperiment(int fabric, const std::string& model, int seed, double energy) {
  ComparedExperiment experiment{fabric, model, seed, {}};
  experiment.result.numbers = {{"feature_energy", energy}, {"outline_energy_m", 0.004}};
  for (int capture = 1; capture <= 4; ++capture)
    experiment.result.captures.push_back({fabric, seed, capture, energy + 0.1 * (capture % 2)});
  return experiment;
}

class ComparisonTableTest : public FileFixture {
 protected:
  ComparisonTableTest() {
    for (const int fabric : {2, 5})
      for (const int seed : {1, 2}) {
        experiments_.push_back(
            MakeExperiment(fabric, "homogeneous", seed, fabric == 2 ? 2.0 + seed : 1.0));
        experiments_.push_back(MakeExperiment(fabric, "bayes", seed, fabric == 2 ? 1.0 : 1.5));
        experiments_.push_back(MakeExperiment(fabric, "circle", seed, 9.0));
        experiments_.back().result.captures.clear();
        experiments_[experiments_.size() - 2].result.belief = {{100.0 * seed, 10, 1e-6, 1e-7}};
      }
  }
  Comparison Summed() const { return SumUp(experiments_, {"homogeneous", "bayes"}, {"circle"}); }

  std::vector<ComparedExperiment> experiments_;
};

TEST_F(ComparisonTableTest, ATableForEachFabricAndOneForAll) {
  const Comparison comparison = Summed();
  ASSERT_EQ(comparison.tables.size(), 3u);
  EXPECT_EQ(comparison.tables[0].choice.chosen, "bayes");
  EXPECT_EQ(comparison.tables[0].choice.captures, 8);
  EXPECT_EQ(comparison.tables[1].choice.chosen, "homogeneous");
  const ComparisonRow& homo = comparison.tables[0].rows[0];
  EXPECT_DOUBLE_EQ(homo.numbers.at("feature_energy").spread.mean, 3.5);
  EXPECT_NEAR(homo.numbers.at("feature_energy").spread.sd, std::sqrt(0.5), 1e-12);
  // Of all: seed 1 (3 + 1)/2, seed 2 (4 + 1)/2.
  const ComparisonTable& all = comparison.tables[2];
  EXPECT_EQ(all.fabric, 0);
  EXPECT_DOUBLE_EQ(all.rows[0].numbers.at("feature_energy").spread.mean, 2.25);
  EXPECT_EQ(all.choice.captures, 16);
  EXPECT_EQ(all.rows[2].model, "circle");
  EXPECT_FALSE(all.rows[0].numbers.contains("elbo"));
}

TEST_F(ComparisonTableTest, ACaptureHeldOutTwiceCountsOnce) {
  for (ComparedExperiment& experiment : experiments_)
    for (CaptureScore& capture : experiment.result.captures) capture.sample = 1;
  EXPECT_EQ(Summed().tables[0].choice.captures, 4);
}

TEST_F(ComparisonTableTest, AModelWithAFailedExperimentIsNotChosen) {
  experiments_[1].result = {};  // fabric 2, bayes, seed 1
  experiments_[1].result.failure = "nothing could be fitted";
  const Comparison comparison = Summed();
  EXPECT_EQ(comparison.tables[0].choice.chosen, "homogeneous");
  EXPECT_EQ(comparison.tables[0].rows[1].failed, 1);
  EXPECT_DOUBLE_EQ(comparison.tables[0].rows[1].numbers.at("feature_energy").spread.mean, 1.0);
  EXPECT_EQ(comparison.tables[2].rows[1].numbers.at("feature_energy").seeds, 1);
  EXPECT_THAT(comparison.failures,
              testing::ElementsAre("fabric 2, bayes, seed 1: nothing could be fitted"));
  EXPECT_THAT(ComparisonText(comparison), HasSubstr("bayes (1 of 2 failed)"));
  EXPECT_THAT(ComparisonText(comparison), HasSubstr("| 3.5 ± 0.71 | 1 | 9 ± 0 |"));
}

TEST_F(ComparisonTableTest, TheChartMarksAModelThatIsNotCompared) {
  for (ComparedExperiment& experiment : experiments_) {
    if (experiment.model == "circle") continue;
    experiment.result.numbers["rollouts"] = 900;
    experiment.result.numbers["train_mse"] = 0.02;
  }
  RenderModelChart(Path("whole"), Summed().tables[0]);
  experiments_[1].result = {};  // fabric 2, bayes, seed 1
  experiments_[1].result.failure = "nothing could be fitted";
  RenderModelChart(Path("lost"), Summed().tables[0]);
  EXPECT_THAT(Read(Path("whole.svg")), Not(HasSubstr("not compared")));
  EXPECT_THAT(Read(Path("lost.svg")), HasSubstr("an experiment has no score: not compared"));
}

TEST_F(ComparisonTableTest, TheHeldOutChartHasEachModelAndTheBounds) {
  for (ComparedExperiment& experiment : experiments_) {
    if (experiment.model == "circle") continue;
    experiment.result.numbers["rollouts"] = 900;
    experiment.result.numbers["train_mse"] = 0.02;
    experiment.result.numbers["parameters"] = 39;
  }
  RenderHeldOutChart(Path("chart"), Summed().tables[0]);
  const std::string svg = Read(Path("chart.svg"));
  for (const char* text : {"bayes", "homogeneous", "a circle of their mean area", "commit"})
    EXPECT_THAT(svg, HasSubstr(text));
}

TEST_F(ComparisonTableTest, BeliefsAreMeansOverSeeds) {
  const Comparison comparison = Summed();
  ASSERT_EQ(comparison.beliefs.size(), 2u);
  EXPECT_EQ(comparison.beliefs[1].fabric, 5);
  EXPECT_DOUBLE_EQ(comparison.beliefs[0].belief.stretch, 150);
  EXPECT_DOUBLE_EQ(comparison.beliefs[0].belief.bend_deviation, 1e-7);
}

TEST_F(ComparisonTableTest, FilesSayTheSame) {
  WriteComparison(Path(""), Summed(), {{"program", "drape_compare"}});
  const std::string csv = Read(Path("comparison.csv")), text = Read(Path("comparison.md"));
  EXPECT_THAT(csv, HasSubstr("\n2,homogeneous,feature_energy,3.5,0.707106781,2,2,0\n"));
  EXPECT_THAT(csv, HasSubstr("\nall,circle,outline_energy_m,0.004,0,2,4,0\n"));
  EXPECT_THAT(csv, Not(HasSubstr("elbo")));
  EXPECT_THAT(text,
              HasSubstr("| held out: energy score of features | 3.5 ± 0.71 | 1 ± 0 | 9 ± 0 |"));
  EXPECT_THAT(text, HasSubstr("outlines [mm] | 4 ± 0 |"));
  EXPECT_THAT(text, HasSubstr("**bayes** is the simplest"));
  EXPECT_THAT(text, HasSubstr("| 2 | bayes | 150 | 10 | 1e-06 | 1e-07 |"));
  const nlohmann::json json = ReadJsonFile(Path("comparison.json"));
  EXPECT_EQ(json["provenance"]["program"], "drape_compare");
  EXPECT_EQ(json["tables"][1]["choice"]["chosen"], "homogeneous");
  EXPECT_EQ(json["tables"][2]["fabric"], "all");
  EXPECT_EQ(json["posteriors"][0]["stretch_n_per_m"][0], 150);
}

TEST(FitNumbers, AreReadFromASummary) {
  nlohmann::json summary = nlohmann::json::parse(R"({
      "mean": {"mse": 0.01, "profile_rms_px": 2, "iou": 0.9, "outline_hausdorff_m": 0.005},
      "seconds": {"grid": 1, "fit": 2, "report": 0.5}, "rollouts": 100,
      "parameters": {"count": 39},
      "posterior": {"kind": "bayes", "seconds": [4, 5], "rollouts": 50, "elbo": null,
                    "log_factors": [1, 2, 3]}})");
  Numbers numbers = FitNumbers(summary, "summary.json");
  EXPECT_EQ(numbers["fit_seconds"], 12.5);
  EXPECT_EQ(numbers["rollouts"], 150);
  EXPECT_EQ(numbers["parameters"], 3);
  EXPECT_FALSE(numbers.contains("elbo"));
  summary["posterior"]["kind"] = "bdp";  // a mean and a deviation each
  EXPECT_EQ(FitNumbers(summary, "summary.json")["parameters"], 6);
  EXPECT_INPUT_ERROR(FitNumbers(nlohmann::json::object(), "summary.json"), "summary.json");
}

}  // namespace
}  // namespace drape
