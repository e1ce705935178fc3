// SPDX-License-Identifier: Apache-2.0
// drape_speed as a user runs it.
#include "tests/tools/tool_fixture.h"
#include "tools/programs/studies/bench/speed_tool.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kSpeed = std::string(DRAPE_BIN_DIR) + "/drape_speed";
const std::string kConfig = std::string(DRAPE_SOURCE_DIR) + "/configs/studies/speed.json";

class SpeedTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {
        kSpeed,          "--fabric=" + kFabric, "--steps=5",           "--repeats=2",
        "--backend=cpu", "--threads=1",         "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

TEST_F(SpeedTool, PrintsOurFiguresBesideThePublishedOnes) {
  Write("figures.json",
        R"({"vertices": [100, 5000], "rows": [{"name": "Another", "machine": "abacus",)"
        R"( "source": "a book", "forward_s": [12.5, 99.5]}]})");
  const ProcessResult result =
      Run({"--mesh=disc:100,disc:150", "--batch=1,3", "--published=" + Path("figures.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("| Another | abacus | 12.5 | – |"));
  EXPECT_THAT(result.out, HasSubstr("| drapefit | 1 CPU thread"));
  EXPECT_THAT(result.out, HasSubstr("of 3 at once |"));
  EXPECT_THAT(result.out, HasSubstr("Another, abacus: a book"));
  EXPECT_THAT(result.out, testing::Not(HasSubstr("99.5")));
  EXPECT_EQ(Read(Path("out/speed.md")), result.out);
  const Json json = ReadJson(Path("out/speed.json"));
  ASSERT_EQ(json["rows"].size(), 4u);
  EXPECT_EQ(json["law"], "reference");
  for (const Json& row : json["rows"]) {
    EXPECT_GT(row["forward_seconds"].get<double>(), 0);
    EXPECT_GT(row["gradient_seconds"].get<double>(), 0);
    EXPECT_EQ(row["backward_seconds"].get<double>(),
              row["gradient_seconds"].get<double>() - row["forward_seconds"].get<double>());
    EXPECT_GT(row["gradient_peak_mb"].get<double>(), 0);
  }
}

TEST_F(SpeedTool, SaysThatItsDiscsAreNotThePublishedOnes) {
  Write("figures.json", R"({"vertices": [100], "rows": []})");
  const ProcessResult result = Run({"--published=" + Path("figures.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("built-in discs of about the published numbers of vertices"));
  EXPECT_THAT(ReadJson(Path("out/speed.json"))["rows"][0]["mesh"], "disc:100");
}

TEST_F(SpeedTool, MistakesAreOneLine) {
  ExpectOneLineError(Run({}), "option 'mesh': is empty");
  ExpectOneLineError(Run({"--mesh=disc:x"}), "disc:x");
  ExpectOneLineError(Run({"--mesh=disc:100", "--fabric=" + Path("no.json")}), "no.json");
  Write("figures.json", R"({"vertices": [1, 2], "rows": [{"name": "A"}]})");
  ExpectOneLineError(Run({"--published=" + Path("figures.json")}), "key 'vertices[0]'");
  Write("figures.json", R"({"vertices": [100], "rows": [{"name": "A", "machine": "", "source": "",)"
                        R"( "forward_s": [1, 2]}]})");
  ExpectOneLineError(Run({"--published=" + Path("figures.json")}), "'rows[0].forward_s'");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(SpeedTool, HelpAndConfigAreComplete) {
  SpeedToolOptions options;
  const OptionTable table = SpeedOptionTable(options);
  EXPECT_EQ(RunProcess({kSpeed, "--help"}).out, table.Help());
  table.ReadConfig(kConfig);
  EXPECT_TRUE(std::filesystem::exists(options.job.material));
  const PublishedSpeeds published = ReadPublishedSpeeds(options.published);
  EXPECT_THAT(published.vertices, testing::ElementsAre(297, 1205, 2699));
  EXPECT_EQ(published.rows.size(), 3u);
}

}  // namespace
}  // namespace drape::test
