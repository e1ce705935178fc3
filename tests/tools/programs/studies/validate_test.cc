// SPDX-License-Identifier: Apache-2.0
// drape_validate as a user runs it.
#include "tools/programs/studies/check/validate.h"

#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kValidate = std::string(DRAPE_BIN_DIR) + "/drape_validate";

class ValidateTool : public ToolFixture {};

TEST_F(ValidateTool, HelpComesFromTheTable) {
  ValidateToolOptions options;
  EXPECT_EQ(RunProcess({kValidate, "--help"}).out, ValidateTable(options).Help());
}

TEST_F(ValidateTool, PrintsAndWritesTheTruthsThatAreAskedFor) {
  const ProcessResult result =
      RunProcess({kValidate, "--filter=uniaxial,turn", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("l at N = 5.381 N/m"));
  EXPECT_THAT(result.out, testing::HasSubstr("0 of 4 reference cases failed"));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("law"), "smooth");
  EXPECT_EQ(summary.at("complete"), true);
  EXPECT_EQ(summary.at("pass"), true);
  ASSERT_EQ(summary.at("cases").size(), 4u);
  const Json& pull = summary.at("cases")[0];
  EXPECT_EQ(pull.at("reference"), 1.05);
  EXPECT_EQ(pull.at("computed").size(), 3u);
  EXPECT_LE(pull.at("error"), pull.at("tolerance"));
  EXPECT_EQ(summary.at("cases")[3].at("group"), "turn");
}

TEST_F(ValidateTool, UnknownGroupsAreOneLineAndLeaveNothing) {
  const ProcessResult result = RunProcess({kValidate, "--filter=drapes", "--out=" + Path("out")});
  ExpectOneLineError(result, "unknown group \"drapes\", expected one of rigidity, cantilever");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

}  // namespace
}  // namespace drape::test
