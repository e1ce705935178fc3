// SPDX-License-Identifier: Apache-2.0
// Flags, --help and the exit codes of the real programs.
#include <regex>

#include "tests/tools/tool_fixture.h"
#include "tools/inputs/fit_options.h"
#include "tools/programs/simulate/simulate_tool.h"

namespace drape::test {
namespace {

class CommandLine : public ToolFixture {};

void ExpectHelpListsAll(const std::string& program, const OptionTable& table) {
  const ProcessResult help = RunProcess({program, "--help=all"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_EQ(help.err, "");
  EXPECT_GE(table.options.size(), 8u);
  const std::string unwrapped = std::regex_replace(help.out, std::regex("\n      (?! )"), " ");
  for (const Option& option : table.options) {
    EXPECT_THAT(help.out, testing::HasSubstr("\n  --" + option.key + "  <"));
    EXPECT_THAT(unwrapped, testing::HasSubstr(" " + option.doc + "\n"));
    EXPECT_THAT(option.doc, testing::Not(testing::HasSubstr("\n")));
  }
  EXPECT_EQ(help.out, table.Help(HelpScope::kAll));
  EXPECT_EQ(RunProcess({program, "--help"}).out, table.Help());
  EXPECT_EQ(RunProcess({program, "-h"}).out, table.Help());
}

TEST_F(CommandLine, HelpListsEachKeyOfTheTable) {
  SimulateOptions simulate;
  ExpectHelpListsAll(kSimulate, SimulateTable(simulate));
  FitToolOptions fit;
  ExpectHelpListsAll(kFit, FitTable(fit));
}

TEST_F(CommandLine, HelpGivesTypeRangeUnitAndDefault) {
  SimulateOptions options;
  const std::string help = SimulateTable(options).Help(HelpScope::kAll);
  EXPECT_THAT(help, testing::HasSubstr("--time_step  <number>, > 0 and ≤ 10 [s], default: 0.05\n"));
  EXPECT_THAT(help, testing::HasSubstr("--steps  <integer>, 0 … 1000000, default: 100\n"));
  EXPECT_THAT(help, testing::HasSubstr("--law  <reference|smooth>, default: smooth\n"));
  EXPECT_THAT(help, testing::HasSubstr("--fabric  <path> or built-in, default: built-in\n"));
}

TEST_F(CommandLine, HelpShowsTheCommonOptionsAndCountsTheOthers) {
  FitToolOptions options;
  const OptionTable table = FitTable(options);
  const std::string help = table.Help();
  EXPECT_THAT(help, testing::HasSubstr("\n  --images  <"));
  EXPECT_THAT(help, testing::Not(testing::HasSubstr("--field_restarts")));
  const std::size_t others = table.options.size() - table.common.size();
  EXPECT_THAT(help, testing::HasSubstr("\n" + std::to_string(others) +
                                       " more with --help=all: data and results; "));
  EXPECT_LT(std::count(help.begin(), help.end(), '\n'), 65);
}

TEST_F(CommandLine, MistakesAreOneLine) {
  ExpectOneLineError(Simulate({"--stepz=3"}), "unknown option '--stepz', did you mean '--steps'?");
  ExpectOneLineError(Simulate({"--undefok=steps"}), "unknown option '--undefok'");
  ExpectOneLineError(Simulate({"here"}), "found 'here', expected --key=value");
  ExpectOneLineError(Simulate({"--time_step"}), "option '--time_step' has no value");
  ExpectOneLineError(Simulate({"--steps=3.5"}),
                     "option 'steps': found '3.5', expected a whole number");
  ExpectOneLineError(Simulate({"--steps=99999999999"}), "expected a whole number, 0 … 1000000");
  ExpectOneLineError(Simulate({"--time_step=nan"}), "found 'nan', expected a number, > 0");
  ExpectOneLineError(Simulate({"--time_step=-0.1"}), "found '-0.1'");
  ExpectOneLineError(Simulate({"--dump_steps=1,,2"}), "option 'dump_steps'");
  ExpectOneLineError(Simulate({"--dump_steps=7"}), "found 7, expected at most steps = 3");
  ExpectOneLineError(Simulate({"--law=hooke"}), "expected one of reference, smooth");
  ExpectOneLineError(Simulate({"--config=" + Path("no.json")}), "no.json: no such file");
  ExpectOneLineError(Simulate({"--solve=static"}), "not flat");
  ExpectOneLineError(RunProcess({kSimulate, "--fabric=" + kFabric}), "option 'out': is missing");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(CommandLine, VersionIsShown) {
  const ProcessResult version = RunProcess({kFit, "--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.out, std::string("drape_fit ") + DRAPE_VERSION + "\n");
}

TEST_F(CommandLine, CheckPrintsATableAndItsVerdict) {
  const std::string config = std::string(DRAPE_SOURCE_DIR) + "/configs/programs/check.json";
  const std::vector<std::string> command = {kCheck, "--config=" + config, "--mesh=disc:120"};
  const ProcessResult result = RunProcess(command);
  EXPECT_EQ(result.exit_code, 0) << result.out;
  EXPECT_THAT(result.out, testing::HasSubstr("0 of 10 checks failed"));
  EXPECT_THAT(result.out, testing::HasSubstr("tangent by the material, step 1e-8"));
  // The reference law has kinks, and a start at 100 % noise is full of them.
  const ProcessResult kinks = RunProcess({kCheck, "--config=" + config, "--law=reference",
                                          "--mesh=disc:120", "--noise=1", "--steps=100"});
  EXPECT_EQ(kinks.exit_code, 1) << kinks.out;
  EXPECT_THAT(kinks.out, testing::HasSubstr("FAIL"));
}

}  // namespace
}  // namespace drape::test
