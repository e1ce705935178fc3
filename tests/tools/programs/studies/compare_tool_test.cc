// SPDX-License-Identifier: Apache-2.0
// drape_compare as a user runs it.
#include <limits>

#include "losses/image/image.h"
#include "physics/material/material_io.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kCompare = std::string(DRAPE_BIN_DIR) + "/drape_compare";

class CompareTool : public ToolFixture {
 protected:
  CompareTool() : data_(AddData()) {}
  ProcessResult Run(const std::vector<std::string>& more, ProcessLimits limits = {}) const {
    limits.charts = charts_;
    std::vector<std::string> command = {kCompare,
                                        "--data=" + data_,
                                        "--data_fabric=3",
                                        "--models=homogeneous,heterogeneous",
                                        "--seeds=1,2",
                                        "--train=2",
                                        "--train_captures=1",
                                        "--face=up",
                                        "--draws=4",
                                        "--mesh=disc:120",
                                        "--coarse_mesh=disc:100",
                                        "--initial_stretch=1",
                                        "--initial_bend=1",
                                        "--initial_lifts=1",
                                        "--candidates_per_round=1",
                                        "--iterations=2",
                                        "--field_modes=3",
                                        "--field_restarts=0",
                                        "--field_iterations=1",
                                        "--num_parameters=2",
                                        "--sigma_px=2",
                                        "--threads=1",
                                        "--calibrate=false",
                                        "--fabric=" + kFabric,
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }

  const std::string data_;
  bool charts_ = false;
};

TEST_F(CompareTool, ComparesAndTakesOverWhatIsDone) {
  charts_ = true;
  const ProcessResult result = Run({});
  charts_ = false;
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("## Fabric 3"));
  EXPECT_THAT(result.out, HasSubstr("other samples"));
  EXPECT_EQ(Read(Path("out/comparison.md")), result.out);
  const std::string csv = Read(Path("out/comparison.csv"));
  EXPECT_THAT(csv, HasSubstr("3,heterogeneous,parameters,45,"));
  EXPECT_THAT(csv, HasSubstr("3,circle,feature_energy,"));
  const Json split = ReadJson(Path("out/fabric_3/split_1.json"));
  EXPECT_EQ(split["train"].size(), 2u);     // capture 1 of two samples
  EXPECT_EQ(split["held_out"].size(), 4u);  // captures 1 and 2 of the other two
  const auto cells = Snapshot(Path("out/cells"));
  EXPECT_EQ(cells.size(), 4u);
  std::filesystem::remove_all(Path("out/fabric_3/heterogeneous/seed_1"));
  ASSERT_EQ(Run({"--models=homogeneous"}).exit_code, 0);  // fewer models need fewer experiments
  EXPECT_FALSE(std::filesystem::exists(Path("out/fabric_3/heterogeneous/seed_1")));
  EXPECT_EQ(Snapshot(Path("out/cells")), cells);
}

TEST_F(CompareTool, SimplerModelsHaveFewerNumbersAndTablesOfTheirForm) {
  charts_ = true;
  const ProcessResult result = Run(
      {"--models=homogeneous,columns,bend,isotropic,linear", "--seeds=1", "--num_parameters=39"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string csv = Read(Path("out/comparison.csv"));
  EXPECT_THAT(csv, HasSubstr("3,isotropic,parameters,2,"));
  EXPECT_THAT(csv, HasSubstr("3,linear,parameters,7,"));
  EXPECT_THAT(csv, HasSubstr("3,columns,parameters,7,"));
  EXPECT_THAT(csv, HasSubstr("3,bend,parameters,1,"));
  EXPECT_THAT(csv, HasSubstr("3,homogeneous,parameters,39,"));
  EXPECT_LT(result.out.find("isotropic ("), result.out.find("linear ("));
  EXPECT_LT(result.out.find("linear ("), result.out.find("columns ("));
  const auto table = [&](const std::string& model) {
    return ReadMaterial(Path("out/fabric_3/" + model + "/seed_1/material.json")).field;
  };
  const StretchTable linear = table("linear").stretch[0];
  for (int k = 0; k < kStretchCols; ++k)
    EXPECT_NEAR(linear.c[0][k], linear.c[5][k], 1e-9 * linear.c[0][k]);
  EXPECT_NE(linear.c[0][0], linear.c[0][2]);
  EXPECT_EQ(table("bend").stretch[0].c[3][1], ReadMaterial(kFabric).field.stretch[0].c[3][1]);
  EXPECT_NE(table("bend").bend[0].b[1][2], ReadMaterial(kFabric).field.bend[0].b[1][2]);
  const MaterialField isotropic = table("isotropic");
  EXPECT_NEAR(isotropic.stretch[0].c[0][0], isotropic.stretch[0].c[0][2], 1e-9);
  EXPECT_NEAR(isotropic.bend[0].b[0][0], isotropic.bend[0].b[2][4], 1e-15);
  EXPECT_EQ(ReadImage(Path("out/models_fabric_3.png")).width, 1100);
  // More numbers never fit worse.
  double last = std::numeric_limits<double>::infinity();
  for (const std::string model : {"isotropic", "linear", "columns", "homogeneous"}) {
    const double cost = ReadJson(Path("out/fabric_3/" + model + "/seed_1/summary.json"))["cost"];
    EXPECT_LE(cost, last) << model;
    last = cost;
  }
}

TEST_F(CompareTool, AGenerativeModelIsScoredBesideFits) {
  const std::vector<std::string> options = {"--models=isotropic,generative", "--seeds=1",
                                            "--mesh=disc:100", "--pool_drapes=512", "--rounds=0"};
  const ProcessResult result = Run(options);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json comparison = ReadJson(Path("out/comparison.json"));
  const Json learned = comparison["runs"][1];
  EXPECT_EQ(learned["model"], "generative");
  EXPECT_GT(learned["energy_cross_validated"], learned["energy_training"]);
  EXPECT_EQ(learned["numbers"]["rollouts"], 512);
  EXPECT_TRUE(std::filesystem::exists(Path("out/pool.json")));
  EXPECT_EQ(comparison["tables"][0]["rows"][1]["model"], "generative");
  const auto before = Snapshot(Path("out/fabric_3"));
  ASSERT_EQ(Run(options).exit_code, 0);
  EXPECT_EQ(Snapshot(Path("out/fabric_3")), before);
}

TEST_F(CompareTool, CtrlCKeepsWhatIsDone) {
  const ProcessResult stopped =
      Run({"--seeds=1"}, {.interrupt_when = Path("out/fabric_3/heterogeneous/seed_1/fit.log")});
  ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 1u);
  EXPECT_FALSE(std::filesystem::exists(Path("out/comparison.csv")));
  ASSERT_EQ(Run({"--seeds=1"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(Path("out/comparison.csv")));
}

TEST_F(CompareTool, SharesHaveTheirOwnExperimentsAndNoTables) {
  EXPECT_EQ(Run({"--list", "--share=1/3"}).out, "fabric_3/heterogeneous/seed_1\n");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessResult share = Run({"--share=2/4"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, HasSubstr("share 2/4: 1 of 1 cells are complete"));
  EXPECT_TRUE(std::filesystem::exists(Path("out/fabric_3/homogeneous/seed_2/material.json")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/fabric_3/homogeneous/seed_1")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/comparison.md")));
  ASSERT_EQ(Run({"--share=0/4"}).exit_code, 0);  // another share makes no other settings
}

TEST_F(CompareTool, MistakesAreOneLine) {
  ExpectOneLineError(Run({"--models=homogeneous,best"}), "option 'models': found 'best'");
  ExpectOneLineError(Run({"--models=homogeneous,homogeneous"}), "option 'models'");
  ExpectOneLineError(Run({"--seeds=2,2"}), "option 'seeds'");
  ExpectOneLineError(Run({"--data_fabric=9"}), "fabric: found 9, expected some of 3");
  ExpectOneLineError(Run({"--train=4"}), "train: found 4");
  ExpectOneLineError(Run({"--train_captures=3"}), "no usable capture to fit");
  ExpectOneLineError(Run({"--fabric=" + kFabric + "," + kFabric}), "option 'materials'");
  ExpectOneLineError(Run({"--fabric=" + Path("no.json")}), "no.json");
  ExpectOneLineError(Run({"--draws=2"}), "draws");
  ExpectOneLineError(Run({"--mesh=disc:3"}), "disc: 3 vertices");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(CompareTool, RunsOfOtherInputsAreNotMixedIn) {
  const std::vector<std::string> options = {"--models=bend", "--seeds=1",
                                            "--fabric=" + Path("start.json")};
  const auto best = [&] {
    const ProcessResult result = Run(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadJson(Path("out/fabric_3/bend/seed_1/summary.json"))["cost"].get<double>();
  };
  Material start = ReadMaterial(kFabric);
  WriteMaterial(Path("start.json"), start);
  const double cost = best();
  for (double& entry : start.field.bend[0].b[0]) entry *= 3.0;
  WriteMaterial(Path("start.json"), start);
  EXPECT_NE(best(), cost);
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 2u);
}

TEST_F(CompareTool, HelpAndConfigsAreComplete) {
  const std::string help = RunProcess({kCompare, "--help=all"}).out;
  const std::string configs = std::string(DRAPE_SOURCE_DIR) + "/configs/studies/compare/";
  for (const auto& [name, cells] : {std::pair("quick.json", 6), std::pair("fabrics.json", 105)}) {
    const Json config = Json::parse(Read(configs + name), nullptr, true, true);
    for (const auto& [key, value] : config.items())
      EXPECT_THAT(help, HasSubstr("\n  --" + key)) << name;
    for (const std::string material : config["fabric"])
      EXPECT_TRUE(std::filesystem::exists(configs + material)) << material;
    const ProcessResult list = RunProcess({kCompare, std::string("--config=") + configs + name,
                                           "--list", "--data=" + data_, "--out=" + Path("out")});
    EXPECT_EQ(list.exit_code, 0) << list.err;
    EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), cells) << name;
  }
}

}  // namespace
}  // namespace drape::test
