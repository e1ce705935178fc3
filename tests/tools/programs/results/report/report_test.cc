// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstdlib>
#include <regex>

#include "tests/tools/tool_fixture.h"
#include "tools/programs/results/report/parts/html_text.h"
#include "tools/programs/results/report/parts/provenance_part.h"
#include "tools/programs/results/report/report_tool.h"

namespace drape::test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kReport = std::string(DRAPE_BIN_DIR) + "/drape_report";

TEST(HtmlText, NoTextBecomesMarkup) {
  EXPECT_EQ(EscapeHtml("<b>\"a\" & b"), "&lt;b&gt;&quot;a&quot; &amp; b");
  EXPECT_THAT(EscapeHtml("\xff"), Not(HasSubstr("\xff")));
  const std::string text = ScriptJson({{"k", "</script><!--\u2028\u2029\xff"}});
  EXPECT_EQ(text, "{\"k\":\"\\u003c/script>\\u003c!--\\u2028\\u2029\ufffd\"}");
}

TEST(HtmlText, Base64IsThatOfTheStandard) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

TEST(HtmlText, TablesOfReportsAreKept) {
  const std::string html = HtmlFromMarkdown("# A\ntext <\n| a | b |\n|---|---|\n| x | 1.5 |\n");
  EXPECT_THAT(html, HasSubstr("<h3>A</h3>"));
  EXPECT_THAT(html, HasSubstr("text &lt;"));
  EXPECT_THAT(html, HasSubstr("<td class=\"number\">1.5</td>"));
  const std::string csv = HtmlFromCsv("runs", "# shared\na,\"b,c\"\n1,2\n3,4\n5,6\n", 2);
  EXPECT_THAT(csv, HasSubstr(">b,c</th>"));
  EXPECT_THAT(csv, HasSubstr("and 1 more rows"));
}

class ReportTest : public ToolFixture {
 protected:
  std::string AddFit(const std::string& name, const Json& more) const {
    std::filesystem::create_directories(Path(name));
    Json summary = {{"tool", "drape_fit"}, {"start_material", "a<b>.json"}};
    summary.update(more);
    Write(name + "/summary.json", summary.dump());
    return Path(name);
  }
  std::string Page(const std::vector<std::string>& folders) const {
    std::vector<ResultFolder> read;
    for (const std::string& folder : folders) read.push_back(ReadResultFolder(folder));
    return MakeReport(read);
  }
};

TEST_F(ReportTest, WarningsComeFirstAndNothingIsMarkup) {
  const std::string page = Page({AddFit(
      "fit", {{"verdict", {{"grade", "do not use"}, {"reasons", {"<script>alert(1)</script>"}}}},
              {"provenance", {{"command", "drape_fit --x=<i>"}}}})});
  EXPECT_THAT(page, HasSubstr("Do not use"));
  EXPECT_THAT(page, HasSubstr("<li>&lt;script&gt;alert(1)&lt;/script&gt;</li>"));
  EXPECT_THAT(page, HasSubstr("drape_fit --x=&lt;i&gt;"));
  EXPECT_THAT(page, HasSubstr("a&lt;b&gt;.json"));
  EXPECT_LT(page.find("Do not use"), page.find("<section id=\"provenance\">"));
  EXPECT_THAT(page, Not(HasSubstr("%%")));
}

TEST_F(ReportTest, ProvenanceTellsHowToRepeat) {
  EXPECT_EQ(ShellLine({"drape_fit", "--x=a'b c", "", "$y"}), "drape_fit '--x=a'\\''b c' '' '$y'");
  const std::string fit =
      AddFit("a fit", {{"provenance",
                        {{"command", Json::array({"drape_fit", "--images=<a>.png"})},
                         {"options", {{"seed", 7}, {"split_seed", 8}, {"mesh", "disc:100"}}},
                         {"inputs", Json::array({{{"path", "<a>.png"}, {"bytes", 12345}}})},
                         {"build", {{"drapefit", "0.1.0"}, {"commit", "763e1da"}}}}}});
  const std::string page = Page({fit});
  EXPECT_THAT(page, HasSubstr("drape_fit '--images=&lt;a&gt;.png'"));
  EXPECT_THAT(page, HasSubstr("drape_fit '--config=" + fit + "/summary.json' --out=NEW"));
  EXPECT_THAT(page, HasSubstr("seed 7, split_seed 8"));
  EXPECT_THAT(page, HasSubstr("drapefit 0.1.0, commit 763e1da"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">12345</td>"));
}

// What is not stored has no part, and what has no interval says so.
TEST_F(ReportTest, MissingPartsAreLeftOut) {
  const std::string page = Page(
      {AddFit("a", Json::object()),
       AddFit("b", {{"verdict",
                     {{"bend_n_m", {{"value", 1e-5}, {"factor_90", 2.0}, {"determined", true}}},
                      {"stretch_n_per_m",
                       {{"value", 100.0}, {"factor_90", 2.0}, {"determined", false}}}}},
                    {"stiffness",
                     {{"c33_n_per_m", {{"fitted", 30.0}}},
                      {"bend_along_weft_n_m", {{"fitted", 2e-6}}}}}})});
  EXPECT_THAT(page, Not(HasSubstr("id=\"images\"")));
  EXPECT_THAT(page, Not(HasSubstr("id=\"posterior\"")));
  EXPECT_THAT(page, HasSubstr("No verdict"));
  EXPECT_THAT(page, HasSubstr("5 … 20"));
  EXPECT_THAT(page, HasSubstr("not measured: from the prior"));
  // The shear rigidity is c33/2; edges along the weft bend the warp.
  EXPECT_THAT(page, HasSubstr("shear rigidity G (c33/2)</th><td class=\"number\">15</td>"));
  EXPECT_THAT(page, HasSubstr("bending, warp direction</th><td class=\"number\">2</td>"));
}

// The sheet of a laboratory, where a summary has one, in place of a table of our own.
TEST_F(ReportTest, LaboratorySheetsAreShown) {
  const Json row = {{"name", "bending length"},
                    {"value", 1.5},
                    {"unit", "cm"},
                    {"low", 1.25},
                    {"high", 1.75},
                    {"source", "from the prior"},
                    {"standard", "ISO <7>"}};
  const Json sheet = {{"title", "material"}, {"rows", {row}}};
  const std::string page =
      Page({AddFit("fit", {{"laboratory", {{"material", sheet}, {"photo", sheet}}},
                           {"stiffness", {{"c33_n_per_m", {{"fitted", 30.0}}}}}})});
  EXPECT_THAT(page, HasSubstr("1.25 … 1.75"));
  EXPECT_THAT(page, HasSubstr("ISO &lt;7&gt;"));
  EXPECT_THAT(page, HasSubstr("not measured: from the prior"));
  EXPECT_THAT(page, Not(HasSubstr("no interval is stored")));
}

// Side by side, drapes of specimens of different sizes would look comparable.
TEST_F(ReportTest, WarnsOfDrapesOfDifferentSizes) {
  const Json usual = {{"specimen_diameter_m", 0.3}, {"support_diameter_m", 0.18}};
  const Json small = {{"specimen_diameter_m", 0.24}, {"support_diameter_m", 0.18}};
  const std::string a = AddFit("a", usual), b = AddFit("b", small), c = AddFit("c", usual);
  const std::string page = Page({a, b});
  EXPECT_THAT(page, HasSubstr("The drapes of b are of specimens of 24 cm on 18 cm, those of a of "
                              "30 cm on 18 cm"));
  EXPECT_LT(page.find("are of specimens of"), page.find("class=\"verdict"));
  EXPECT_THAT(Page({a, c}), Not(HasSubstr("are of specimens of")));
}

TEST_F(ReportTest, RefusesOtherFolders) {
  const std::string out = "--out=" + Path("report.html");
  Write("report.html", "earlier");
  std::filesystem::create_directories(Path("empty"));
  std::filesystem::create_directories(Path("broken"));
  Write("broken/summary.json", "{\"tool\": ");
  ExpectOneLineError(RunProcess({kReport, Path("none"), out}), "no such folder");
  ExpectOneLineError(RunProcess({kReport, Path("empty"), out}), "has no results");
  ExpectOneLineError(RunProcess({kReport, Path("broken"), out}), "summary.json");
  ExpectOneLineError(RunProcess({kReport, Path("report.html"), out}), "is not a folder");
  ExpectOneLineError(RunProcess({kReport, out}), "expected at least one folder");
  EXPECT_EQ(Read(Path("report.html")), "earlier");
}

std::string FindBrowser() {
  for (const char* name : {"chromium-headless-shell", "chromium"})
    if (RunProcess({"/bin/sh", "-c", std::string("command -v ") + name}).exit_code == 0)
      return name;
  return "";
}

// In a browser, from a file: every part is filled, the drape is drawn, no error, no request.
TEST_F(ReportTest, OpensInABrowser) {
  const std::string browser = FindBrowser();
  if (browser.empty()) GTEST_SKIP() << "neither chromium-headless-shell nor chromium is installed";
  ASSERT_EQ(
      Simulate({"--mesh=disc:300", "--steps=60",
                "--start=" + std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json"})
          .exit_code,
      0);
  const ProcessResult fit =
      RunProcess({kFit, "--images=" + Path("out/silhouette.png"), "--material=" + kFabric,
                  "--mesh=disc:150", "--coarse_mesh=disc:100", "--initial_stretch=1",
                  "--initial_bend=0.5,1", "--initial_lifts=0.5,1", "--candidates_per_round=3,2,1",
                  "--num_parameters=2", "--iterations=4,4,6", "--out=" + Path("fit")});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const ProcessResult report =
      RunProcess({kReport, Path("fit"), Path("out"), "--out=" + Path("report.html")});
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_LT(std::filesystem::file_size(Path("report.html")), 2000000U);
  const ProcessResult page =
      RunProcess({"/usr/bin/env", browser, "--headless", "--no-sandbox", "--enable-logging=stderr",
                  "--virtual-time-budget=6000", "--window-size=1000,1000", "--dump-dom",
                  "file://" + Path("report.html")});
  EXPECT_THAT(page.out, HasSubstr("data-ready=\"yes\""));
  EXPECT_THAT(page.out, HasSubstr("data-errors=\"0\""));
  for (const char* id : {"verdict", "images", "material", "drape", "spectrum", "provenance"})
    EXPECT_THAT(page.out, HasSubstr(std::string("<section id=\"") + id + "\">"));
  EXPECT_THAT(page.out, HasSubstr("class=\"fitted\""));
  std::smatch drawn;
  ASSERT_TRUE(std::regex_search(page.out, drawn, std::regex("data-drawn=\"([0-9]+)\"")));
  EXPECT_GT(std::stoi(drawn[1]), 5000);
  EXPECT_THAT(page.out, testing::ContainsRegex("data-charts=\"[1-9]"));
  EXPECT_THAT(page.err, Not(HasSubstr("Content Security Policy")));
  EXPECT_THAT(page.err, Not(HasSubstr("Uncaught")));
}

// Without its script, the page has all numbers.
TEST_F(ReportTest, TablesNeedNoScript) {
  std::string page = Page({AddFit(
      "fit", {{"spectrum", {{"singular_values", {3.0, 0.25}}, {"determined_directions", 1}}},
              {"parameters", {{"prior_sigma", 1.0}}}})});
  page.erase(page.find("<script type=\"application/json\""));
  EXPECT_THAT(page,
              HasSubstr("<td class=\"number\">0.25</td><td class=\"text\">of the prior</td>"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
}

}  // namespace
}  // namespace drape::test
