// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/option_table.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "tests/physics/file_fixture.h"
#include "tools/cli/tool_main.h"

namespace drape {
namespace {

class OptionTables : public FileFixture {
 protected:
  std::string path_ = "there", mesh_ = "disc:5";
  int count_ = 1;
  double share_ = 0.5;
  bool loud_ = false;
  std::vector<double> factors_ = {1, 2};
  std::vector<std::string> files_;
  const OptionTable table_ = {
      .tool = "t",
      .summary = "s",
      .example = "e",
      .notes = "n",
      .options = {
          {.key = "path", .value = &path_, .doc = "d", .is_path = true},
          {.key = "mesh", .value = &mesh_, .doc = "d", .is_path = true, .words = {"disc:"}},
          {.key = "count", .value = &count_, .doc = "d", .range = {.least = 1}},
          {.key = "share", .value = &share_, .doc = "d", .range = {.least = 0, .most = 1}},
          {.key = "loud", .value = &loud_, .doc = "d"},
          {.key = "factors",
           .value = &factors_,
           .doc = "d",
           .range = {.least = 0, .above_least = true}},
          {.key = "files", .value = &files_, .doc = "d", .is_path = true, .required = true}}};
};

TEST_F(OptionTables, ReadEachTypeFromAConfig) {
  table_.ReadConfig(Write("c.json", R"({"path": "a/b", "mesh": "disc:9", "count": 3, "share": 1,
      "loud": true, "factors": [0.5, 4], "files": ["x.png", "/y.png"]})"));
  EXPECT_EQ(path_, Path("a/b"));
  EXPECT_EQ(mesh_, "disc:9");
  EXPECT_EQ(count_, 3);
  EXPECT_EQ(share_, 1.0);
  EXPECT_TRUE(loud_);
  EXPECT_THAT(factors_, testing::ElementsAre(0.5, 4.0));
  EXPECT_THAT(files_, testing::ElementsAre(Path("x.png"), "/y.png"));
}

TEST_F(OptionTables, ReadEachTypeFromText) {
  table_.Set("path", "a/b", "w");
  table_.Set("count", "3", "w");
  table_.Set("share", "2.5e-1", "w");
  table_.Set("loud", "true", "w");
  table_.Set("factors", "8", "w");
  table_.Set("files", "x,y", "w");
  EXPECT_EQ(path_, "a/b");
  EXPECT_EQ(count_, 3);
  EXPECT_EQ(share_, 0.25);
  EXPECT_TRUE(loud_);
  EXPECT_THAT(factors_, testing::ElementsAre(8.0));
  EXPECT_THAT(files_, testing::ElementsAre("x", "y"));
}

TEST_F(OptionTables, KeepARefusedValueOut) {
  EXPECT_INPUT_ERROR(table_.Set("count", "0", "w"),
                     "w: option 'count': found '0', expected a whole number, ≥ 1");
  EXPECT_INPUT_ERROR(table_.Set("share", "1.01", "w"), "expected a number, 0 … 1");
  EXPECT_INPUT_ERROR(table_.Set("share", "1x", "w"), "found '1x'");
  EXPECT_INPUT_ERROR(table_.Set("loud", "yes", "w"), "expected true or false");
  EXPECT_INPUT_ERROR(table_.Set("factors", "1,0", "w"), "expected a number, > 0");
  EXPECT_INPUT_ERROR(table_.Set("factors", "", "w"), "at least one value");
  EXPECT_INPUT_ERROR(table_.Set("mesh", "", "w"), "found '', expected a file or disc:");
  EXPECT_INPUT_ERROR(table_.Set("files", "a,,", "w"), "option 'files'");
  EXPECT_INPUT_ERROR(table_.Set("volume", "1", "w"), "unknown option 'volume'");
  EXPECT_EQ(count_, 1);
  EXPECT_EQ(share_, 0.5);
  EXPECT_THAT(factors_, testing::ElementsAre(1.0, 2.0));
}

TEST_F(OptionTables, ConfigTypesAreStrict) {
  const auto read = [&](const std::string& text) { table_.ReadConfig(Write("c.json", text)); };
  EXPECT_INPUT_ERROR(read(R"({"count": "3"})"), "key 'count': found \"3\", expected a number");
  EXPECT_INPUT_ERROR(read(R"({"count": 3.5})"), "found 3.5, expected a whole number");
  EXPECT_INPUT_ERROR(read(R"({"path": 3})"), "expected a text in quotes");
  EXPECT_INPUT_ERROR(read(R"({"loud": 1})"), "expected true or false");
  EXPECT_INPUT_ERROR(read(R"({"factors": 3})"), "expected a list in brackets");
  EXPECT_INPUT_ERROR(read(R"({"factors": [3, "4"]})"), "expected a number");
  EXPECT_INPUT_ERROR(read(R"({"count": {"a": 1}})"), "key 'count'");
  EXPECT_INPUT_ERROR(read("[]"), "c.json");
  EXPECT_INPUT_ERROR(read(R"({"cuont": 1})"), "allowed: path mesh count share loud factors files");
}

TEST_F(OptionTables, HelpIsGroupedAndWrapped) {
  OptionTable table = table_;
  const auto lines = [](const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  };
  EXPECT_THAT(lines(table.Help()), testing::Contains("options:"));
  table.options = Concatenate(Grouped("first", table_.options),
                              Grouped("second", {{.key = "late", .value = &loud_, .doc = ""}}));
  for (int i = 0; i < 60; ++i) table.options.back().doc += "wörd ";
  table.options.back().doc += "end";
  table.common = {"files", "late"};
  const std::string all = table.Help(HelpScope::kAll);
  EXPECT_LT(all.find("common options:\n  --files  <"), all.find("\n  --late  <"));
  EXPECT_LT(all.find("\n  --late  <"), all.find("\nfirst:\n  --path  <"));
  EXPECT_EQ(all.find("second"), std::string::npos);  // all of it is common
  for (const std::string& line : lines(all))
    EXPECT_LE(line.size() - std::count(line.begin(), line.end(), '\xb6'), 100u) << line;
  EXPECT_THAT(lines(table.Help()), testing::Contains("6 more with --help=all: first"));
  EXPECT_THAT(table.Help(), testing::Not(testing::HasSubstr("--path")));
  table.common = {"nothing"};
  EXPECT_DEATH(table.Help(), "t has no option nothing");
}

TEST_F(OptionTables, RequireWhatHasNoDefault) {
  EXPECT_INPUT_ERROR(table_.CheckRequired(), "option 'files': is missing");
  table_.Set("files", "x", "w");
  table_.CheckRequired();
}

enum class Colour { kRed, kBlue };
constexpr auto EnumNames(Colour) {
  return MakeNames<Colour>({{Colour::kRed, "red"}, {Colour::kBlue, "blue"}});
}

struct Paint {
  Colour colour = Colour::kBlue;
  double thickness = 0.5;
  int layers = 2;
};
template <MutableOrConst<Paint> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [colour, thickness, layers] = options;
  visit(colour, Field{.key = "colour", .doc = "d"});
  visit(thickness, Field{.key = "thickness", .doc = "d", .unit = "mm", .range = {.least = 0}});
  visit(layers, Field{.key = "layers", .doc = "d", .range = {.least = 1}, .is_option = false});
}

TEST(FieldOptions, FollowFromTheDescriptionOfTheFields) {
  Paint paint;
  const OptionTable table{
      .tool = "t", .summary = "s", .example = "e", .notes = "n", .options = FieldOptionList(paint)};
  ASSERT_EQ(table.options.size(), 2u);
  EXPECT_THAT(table.Help(), testing::HasSubstr("--colour  <red|blue>, default: blue"));
  EXPECT_THAT(table.Help(), testing::HasSubstr("--thickness  <number>, ≥ 0 [mm], default: 0.5"));
  table.Set("colour", "red", "w");
  EXPECT_EQ(paint.colour, Colour::kRed);
  EXPECT_INPUT_ERROR(table.Set("colour", "green", "w"), "found 'green', expected one of red, blue");
  EXPECT_EQ(paint.colour, Colour::kRed);
}

TEST(FieldCheck, NamesAFieldOutOfItsRange) {
  Paint paint;
  CheckFields(paint);
  paint.layers = 0;
  EXPECT_DEATH(CheckFields(paint), "layers");
}

TEST(ProgressTexts, SayWhatIsLeft) {
  EXPECT_EQ(ProgressText("fit", 0.0, {}, "grid"), "fit  0 %  grid");
  EXPECT_EQ(ProgressText("fit", 0.25, 30.0, "grid"), "fit  25 %  grid, about 30 s left");
  EXPECT_EQ(ProgressText("fit", 0.1, 900.0, ""), "fit  10 %, about 15 min left");
  EXPECT_EQ(ProgressText("fit", 1.0, 0.0, "done"), "fit  100 %  done");
}

TEST(TimeLefts, SayNothingBeforeEnoughIsKnown) {
  TimeLeft left;
  EXPECT_FALSE(left.Seconds());
  left.Update(5.5, 0.01);  // the first task of a batch that took the first 18 % of a run
  EXPECT_FALSE(left.Seconds());
  EXPECT_FALSE(left.Seconds());
  left.Update(5.5, 0.17);
  left.Update(5.5, 0.18);  // the last one
  ASSERT_TRUE(left.Seconds());
  EXPECT_NEAR(*left.Seconds(), 26, 1);
  left.Update(9.5, 0.19);  // the first one of the next batch
  EXPECT_NEAR(*left.Seconds(), 21, 1);
  TimeLeft quick;
  quick.Update(0.1, 0.9);
  EXPECT_FALSE(quick.Seconds());
}

TEST(TimeLefts, FollowTheRateOfTheRun) {
  TimeLeft even;
  for (int second = 1; second <= 50; ++second) even.Update(second, 0.01 * second);
  EXPECT_NEAR(*even.Seconds(), 50, 1e-9);  // 51 at 49 s, a second ago
  TimeLeft slower;                         // ten times as slow after 20 s: 160 s are left after 60
  for (int second = 1; second <= 20; ++second) slower.Update(second, 0.025 * second);
  for (int second = 21; second <= 60; ++second) slower.Update(second, 0.5 + 0.0025 * (second - 20));
  EXPECT_GT(*slower.Seconds(), 50);  // the mean rate says 40
  EXPECT_LE(*slower.Seconds(), 160);
  TimeLeft stuck;  // a fraction that falls back counts as no work
  stuck.Update(10, 0.5);
  stuck.Update(12, 0.4);
  stuck.Update(12, 0.4);
  EXPECT_NEAR(*stuck.Seconds(), 12, 1);
}

std::string Printed(bool is_terminal, int updates, const char* line = nullptr) {
  char* text = nullptr;
  size_t size = 0;
  std::FILE* out = open_memstream(&text, &size);
  {
    Progress progress("p", out, is_terminal);
    if (line != nullptr) progress.Say(line);
    for (int i = 0; i < updates; ++i) {
      progress.Update(0.5, "n");
      timespec pause = {0, 60'000'000};
      nanosleep(&pause, nullptr);
    }
  }
  std::fclose(out);
  const std::string printed(text, size);
  std::free(text);
  return printed;
}

TEST(ProgressLines, RewriteOneLineOnATerminalAndKeepQuietInAPipe) {
  const std::string terminal = Printed(true, 5);
  EXPECT_THAT(terminal, testing::HasSubstr("\r\033[Kp  50 %  n"));
  EXPECT_TRUE(terminal.ends_with("\r\033[K"));
  EXPECT_THAT(terminal, testing::Not(testing::HasSubstr("\n")));
  EXPECT_EQ(Printed(false, 5), "");
}

TEST(ProgressLines, ALineIsSaidOnceAboveTheProgress) {
  const std::string terminal = Printed(true, 5, "said");
  EXPECT_TRUE(terminal.starts_with("\r\033[Ksaid\np  50 %")) << terminal;
  EXPECT_EQ(terminal.find("said"), terminal.rfind("said"));
  EXPECT_EQ(Printed(false, 5, "said"), "");
}

}  // namespace
}  // namespace drape
