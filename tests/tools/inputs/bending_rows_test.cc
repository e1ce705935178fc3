// SPDX-License-Identifier: Apache-2.0
// Rows of a table of bending measurements as the material of each program that reads one.
#include "physics/material/material_io.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

class BendingRows : public ToolFixture {
 protected:
  // Invented numbers.
  BendingRows()
      : table_(Write("set.csv",
                     "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear "
                     "diag[SI*1e9], nonlinear warp[SI*1e12], nonlinear weft[SI*1e12], nonlinear "
                     "diag[SI*1e12]\n0.2, 9000, 7000, 8000, -20000, -10000, -15000\n"
                     "0.15, 3000, 5000, 4000, -6000, -9000, -8000\n")) {}

  std::string Program(const std::string& name) const { return DRAPE_BIN_DIR "/" + name; }

  const std::string table_;
};

TEST_F(BendingRows, DrapeLikeTheTablesThatTheyStandFor) {
  const std::string row = table_ + "#2";
  Material same = ReadMaterial(row + ":" + kFabric);
  EXPECT_EQ(same.field.density, 0.15);
  same.name = "same";
  WriteMaterial(Path("same.json"), same, Convention::kArcsim);
  const ProcessResult measured = Simulate({"--fabric=" + row + ":" + kFabric});
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  const std::string drape = Read(Path("out/drape.obj"));
  EXPECT_THAT(Read(Path("out/summary.json")), HasSubstr("set#2"));
  ASSERT_EQ(Simulate({"--fabric=" + Path("same.json")}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/drape.obj")), drape);
}

TEST_F(BendingRows, EachProgramNamesWhatIsMissing) {
  const std::string out = "--out=" + Path("out"), start = std::string("--start=") +
                                                          DRAPE_SOURCE_DIR +
                                                          "/configs/starts/six_waves.json";
  const std::string image = AddDisc("disc.png", 0.12);
  const std::vector<std::vector<std::string>> commands = {
      {Program("drape_simulate"), out},
      {Program("drape_check")},
      {Program("drape_equilibria"), out},
      {Program("drape_predict"), out},
      {Program("drape_gradients"), out},
      {Program("drape_fit"), "--images=" + image, out},
      {Program("drape_bench"), start, out},
      {Program("drape_compare"), "--data=" + AddData(), "--data_fabric=3", "--seeds=1", "--train=2",
       out}};
  for (std::vector<std::string> command : commands) {
    const auto run = [&](const std::string& fabric) {
      std::vector<std::string> all = command;
      all.push_back("--fabric=" + fabric);
      return RunProcess(all);
    };
    ExpectOneLineError(run(table_ + "#1"), "set.csv#1: has bending alone, expected ");
    ExpectOneLineError(run(table_ + "#3:" + kFabric), "has no row '3', expected 1 to 2");
    EXPECT_FALSE(std::filesystem::exists(Path("out"))) << command[0];
  }
}

// A config file names the base as it names the table, relative to its own folder.
TEST_F(BendingRows, AConfigNamesTheBaseBesideIt) {
  std::filesystem::copy_file(kFabric, Path("base.json"));
  Write("config.json", R"({"fabric": "set.csv#2:base.json"})");
  const ProcessResult result =
      RunProcess({Program("drape_simulate"), "--config=" + Path("config.json"), "--mesh=disc:100",
                  "--steps=1", "--out=" + Path("out")});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

// A table of ARCSim's form with negative entries, as measured ones have.
TEST_F(BendingRows, NegativeEntriesAreAllNamedAndCanBeRaised) {
  Write("knit.json",
        R"({"density":0.2,"stretching":[[16,-14,34,36],[46,53,261,-29],[49,87,206,22],)"
        R"([123,105,365,44],[139,73,413,-174],[127,85,405,32]],"damping":0.1,)"
        R"("pcb_bending_warp":[1e-5,0],"bending":[[2e-5,3e-5,3e-5,3e-5,2e-5],)"
        R"([2e-5,1e-5,1e-5,2e-5,9e-6],[1e-5,7e-6,1e-5,2e-5,2e-5]]})");
  const std::string knit = "--fabric=" + Path("knit.json");
  ExpectOneLineError(Simulate({knit}),
                     "key 'stretching[0][1]': found -14, expected ≥ 0 (only the reference law "
                     "accepts a negative stiffness; --min_relative_stiffness=0.1, where a program "
                     "has it, raises such entries); also negative: stretching[1][3] = -29, "
                     "stretching[4][3] = -174");
  const ProcessResult raised = Simulate({knit, "--min_relative_stiffness=0.1"});
  EXPECT_EQ(raised.exit_code, 0) << raised.err;
  EXPECT_THAT(raised.err, HasSubstr("'damping' is ignored"));
  EXPECT_THAT(raised.err, HasSubstr("'pcb_bending_warp' is ignored"));
  EXPECT_THAT(raised.err, HasSubstr("were raised to 0.1"));
  EXPECT_EQ(Simulate({knit, "--law=reference"}).exit_code, 0);
}

}  // namespace
}  // namespace drape::test
