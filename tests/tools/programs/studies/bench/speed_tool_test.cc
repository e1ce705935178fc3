// SPDX-License-Identifier: Apache-2.0
// drape_speed as a user runs it.
#include "solver/studies/bench/speed_study.h"
#include "tests/tools/tool_fixture.h"

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
  ASSERT_EQ(json["cells"].size(), 8u);
  EXPECT_EQ(json["settings"]["law"], "reference");
  for (std::size_t k = 0; k < 8; k += 2) {
    const Json &forward = json["cells"][k]["result"], &gradient = json["cells"][k + 1]["result"];
    EXPECT_GT(forward["seconds"].get<double>(), 0);
    EXPECT_GT(gradient["seconds"].get<double>(), 0.0);
    EXPECT_EQ(gradient["repeats"], 2);
    EXPECT_GT(gradient["peak_mb"].get<double>(), 0);
  }
}

TEST_F(SpeedTool, SharesAreGatheredAndAChangedMaterialIsMeasuredAgain) {
  Write("wool.json", Read(kFabric));
  const std::string mesh = "--mesh=disc:100", material = "--fabric=" + Path("wool.json");
  EXPECT_EQ(Run({mesh, material, "--list"}).out,
            "disc:100, batch 1, forward\ndisc:100, batch 1, gradient\n");
  const ProcessResult share = Run({mesh, material, "--share=1/2"});
  EXPECT_THAT(share.out, HasSubstr("share 1/2: 1 of 1 cells are complete"));
  const auto cells = Snapshot(Path("out/cells"));
  ASSERT_EQ(cells.size(), 1u);
  ASSERT_EQ(Run({mesh, material}).exit_code, 0);
  const Json whole = ReadJson(Path("out/speed.json"))["cells"];
  EXPECT_THAT(cells.begin()->second, HasSubstr(whole[1]["result"]["seconds"].dump()));
  ASSERT_EQ(Run({mesh, material}).exit_code, 0);
  EXPECT_EQ(ReadJson(Path("out/speed.json"))["cells"], whole);
  Write("wool.json", Read(kFabric) + " ");
  ASSERT_EQ(Run({mesh, material}).exit_code, 0);
  EXPECT_EQ(Snapshot(Path("out/cells")).size(), 4u);
}

TEST_F(SpeedTool, SaysThatItsDiscsAreNotThePublishedOnes) {
  Write("figures.json", R"({"vertices": [100], "rows": []})");
  const ProcessResult result = Run({"--published=" + Path("figures.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("built-in discs of about the published numbers of vertices"));
  EXPECT_EQ(ReadJson(Path("out/speed.json"))["cells"][0]["input"]["mesh"], "disc:100");
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

TEST_F(SpeedTool, ItsConfigurationIsComplete) {
  EXPECT_EQ(RunProcess({kSpeed, "--config=" + kConfig, "--list", "--out=" + Path("out")}).out,
            "disc:297, batch 1, forward\ndisc:297, batch 1, gradient\n"
            "disc:1205, batch 1, forward\ndisc:1205, batch 1, gradient\n"
            "disc:2699, batch 1, forward\ndisc:2699, batch 1, gradient\n");
  const Json published =
      ReadPublishedSpeeds(std::string(DRAPE_SOURCE_DIR) + "/configs/studies/speed_published.json");
  EXPECT_EQ(published["rows"].size(), 3u);
}

}  // namespace
}  // namespace drape::test
