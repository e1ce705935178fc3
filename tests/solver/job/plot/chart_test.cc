// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/chart.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "physics/util/atomic_file.h"
#include "solver/job/plot/gnuplot.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/io_error.h"

namespace drape {
namespace {

using testing::HasSubstr;
using testing::Not;

class ChartTest : public FileFixture {
 protected:
  static Chart SmallChart() {
    return {.series = {{.title = "line", .points = {{1, 1}, {2, 3}, {4, 2}}}}};
  }
  std::string Svg(const Picture& picture) {
    WritePicture(Path("chart.svg"), picture);
    return ReadWholeFile(Path("chart.svg"));
  }
};

// A picture with the text at every place that takes one.
Picture RenderPicture(const std::string& text) {
  Chart chart{.title = text,
              .x = {.label = text, .ticks = {{{1.0, text}}}},
              .y = {.label = text, .log = true, .room = 0.1},
              .colour = {.label = text, .ticks = {{{1.0, text}}}},
              .labels = {{.text = text, .at = {1, 1}},
                         {.text = text, .at = {0.5, 0.5}, .in_picture = true}}};
  for (const Mark mark : {Mark::kLine, Mark::kSteps, Mark::kLinePoints, Mark::kPoints,
                          Mark::kErrorBars, Mark::kBars, Mark::kSquares})
    chart.series.push_back(
        {.title = text, .mark = mark, .points = {{1, 1}, {2, 2}}, .values = {0.1, 0.2}});
  chart.series.push_back({.title = text, .mark = Mark::kSquares});
  chart.series.push_back(
      {.mark = Mark::kPolygons, .points = {{1, 1}, {2, 1}, {1, 2}}, .values = {1, 1, 1}});
  return {.title = text, .charts = {chart}};
}

// Names of files and methods come from users.
TEST_F(ChartTest, NoTextIsExecuted) {
  const std::string planted = Path("planted"), command = "touch " + planted;
  const std::vector<std::string> texts = {"`" + command + "`",
                                          "$(" + command + ")",
                                          "\"; system('" + command + "') #",
                                          "'; system('" + command + "') #",
                                          "''; system(\"" + command + "\") #",
                                          "\\'; system('" + command + "') #",
                                          "a\nsystem '" + command + "'\n",
                                          "a\r!" + command + "\r",
                                          "a\n!" + command + "\n",
                                          "\nEND\nsystem '" + command + "'\n",
                                          "'",
                                          "''",
                                          "@ARGV[1]",
                                          "a' . system('" + command + "') . '",
                                          "<" + command,
                                          "%s%n%d%%%",
                                          "\\\n!" + command,
                                          std::string("a\0b\x01\x7f", 5),
                                          std::string("\xff\xfe\xc3(\xed\xa0\x80"),
                                          std::string(20000, 'x'),
                                          "{/Bold a}_b^c&{d}~e{.8-}@f",
                                          "columnheader(1)",
                                          "\\"};
  for (const std::string& text : texts) {
    SCOPED_TRACE(text.substr(0, 60));
    ASSERT_NO_THROW(WritePicture(Path("chart.png"), RenderPicture(text)));
    EXPECT_GT(ReadImage(Path("chart.png")).width, 0);
    EXPECT_FALSE(std::filesystem::exists(planted));
  }
}

TEST_F(ChartTest, TextsAreShownAsTheyAre) {
  const std::string svg = Svg(RenderPicture("50% of {a}_b^c `d` 'e' \"f\" \\n @g µ"));
  EXPECT_THAT(svg, HasSubstr("50% of {a}_b^c `d` ’e’ "));
  EXPECT_THAT(svg, HasSubstr("\\n @g µ"));
  EXPECT_THAT(Svg(RenderPicture("<script>&</script>")), Not(HasSubstr("<script>")));
}

TEST_F(ChartTest, TheStartUpFileOfTheUserIsNotRead) {
  const char* home = std::getenv("HOME");
  const std::string before = home == nullptr ? "" : home;
  WriteFileAtomically(Path(".gnuplot"), "system 'touch " + Path("planted") + "'\n");
  setenv("HOME", Path("").c_str(), 1);
  WritePicture(Path("chart.png"), {.charts = {SmallChart()}});
  home == nullptr ? unsetenv("HOME") : setenv("HOME", before.c_str(), 1);
  EXPECT_FALSE(std::filesystem::exists(Path("planted")));
}

TEST_F(ChartTest, SizesFollowTheNumberOfCharts) {
  WritePicture(Path("chart.png"), {.charts = {SmallChart(), SmallChart(), SmallChart()}});
  EXPECT_EQ(ReadImage(Path("chart.png")).width, 2 * 620);
  EXPECT_EQ(ReadImage(Path("chart.png")).height, 2 * 440);
}

TEST_F(ChartTest, ASeriesWithoutAPointIsNotInTheKey) {
  Chart chart = SmallChart();
  chart.y.log = true;
  chart.series.push_back({.title = "lost", .points = {{1, std::nan("")}, {2, -1}}});
  EXPECT_THAT(Svg({.charts = {chart}}), testing::AllOf(HasSubstr("line"), Not(HasSubstr("lost"))));
  chart.series.erase(chart.series.begin());
  EXPECT_THAT(Svg({.charts = {chart}}), HasSubstr("nothing to show"));
}

TEST_F(ChartTest, AFolderThatIsMissingIsNamed) {
  EXPECT_IO_ERROR(WritePicture(Path("absent/chart.png"), {.charts = {SmallChart()}}), "absent");
}

// The page of the results draws all charts from their descriptions where gnuplot is missing.
TEST_F(ChartTest, WithoutGnuplotEachPictureIsDescribed) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const std::string note = TryPictures([&] {
    WritePicture(Path("first.png"), {.charts = {SmallChart()}});
    WritePicture(Path("second.png"), {.charts = {SmallChart()}});
  });
  EXPECT_INPUT_ERROR(WritePicture(Path("third.png"), {.charts = {SmallChart()}}), "gnuplot");
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(note, testing::StartsWith("no pictures: gnuplot"));
  for (const char* name : {"first", "second"}) {
    EXPECT_TRUE(std::filesystem::exists(Path(std::string(name) + ".chart.json"))) << name;
    EXPECT_FALSE(std::filesystem::exists(Path(std::string(name) + ".png"))) << name;
  }
}

TEST(QuoteForGnuplot, KeepsUtf8AndNothingThatEndsTheText) {
  EXPECT_EQ(QuoteForGnuplot("it's `a`\n\"b\"\t\\"), "'it’s `a` \"b\" \\'");
  EXPECT_EQ(QuoteForGnuplot("µ→𝜃"), "'µ→𝜃'");
  EXPECT_EQ(QuoteForGnuplot("\xff-\xc2-\xe2\x82"),
            "'?-?-?"
            "?'");
}

// The description is beside the picture, for pages that draw it, also without gnuplot.
TEST_F(ChartTest, DescriptionIsStoredBesideAPng) {
  Chart chart = SmallChart();
  chart.x = {.label = "time [s]", .log = true};
  chart.series[0].points.emplace_back(std::nan(""), 1.0 / 3.0);
  chart.series[0].title = "\xff<";
  WritePicture(Path("map.png"), {.title = "title", .charts = {chart}});
  const auto json = nlohmann::json::parse(ReadWholeFile(Path("map.chart.json")));
  EXPECT_EQ(json.at("format"), "drapefit-chart");
  const auto& stored = json.at("charts").at(0);
  EXPECT_EQ(stored.at("x").at("label"), "time [s]");
  EXPECT_EQ(stored.at("x").at("log"), true);
  EXPECT_EQ(stored.at("series").at(0).at("mark"), "line");
  EXPECT_EQ(stored.at("series").at(0).at("points").dump(),
            "[[1.0,1.0],[2.0,3.0],[4.0,2.0],[null,0.333333]]");
  WritePicture(Path("other.svg"), {.charts = {chart}});
  EXPECT_FALSE(std::filesystem::exists(Path("other.chart.json")));
}

}  // namespace
}  // namespace drape
