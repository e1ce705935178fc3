// SPDX-License-Identifier: Apache-2.0
// The fabric of each program that reads one.
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

class FabricOption : public ToolFixture {
 protected:
  std::string Program(const std::string& name) const { return DRAPE_BIN_DIR "/" + name; }
};

// Without the option the fabric is that of a file in configs.
TEST_F(FabricOption, TheDefaultIsBuiltIn) {
  const std::vector<std::string> command = {Program("drape_simulate"), "--mesh=disc:100",
                                            "--steps=2", "--out=" + Path("out")};
  ASSERT_EQ(RunProcess(command).exit_code, 0);
  const std::string drape = Read(Path("out/drape.obj"));
  EXPECT_EQ(ReadJson(Path("out/summary.json")).at("material"), "synthetic_shirt");
  std::vector<std::string> same = command;
  same.push_back(std::string("--fabric=") + DRAPE_SOURCE_DIR +
                 "/configs/fabrics/synthetic_shirt.json");
  ASSERT_EQ(RunProcess(same).exit_code, 0);
  EXPECT_EQ(Read(Path("out/drape.obj")), drape);
}

TEST_F(FabricOption, EachProgramNamesWhatIsMissing) {
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
    command.push_back("--fabric=3");
    ExpectOneLineError(RunProcess(command),
                       "3: no such file; a fabric of the data set is named by --data_fabric");
    EXPECT_FALSE(std::filesystem::exists(Path("out"))) << command[0];
  }
}

// A table of ARCSim's form with negative entries, as measured ones have.
TEST_F(FabricOption, NegativeEntriesAreAllNamedAndCanBeRaised) {
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
