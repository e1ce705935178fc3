// SPDX-License-Identifier: Apache-2.0
// The pages of drape_report, opened in a browser.
#include <gmock/gmock.h>

#include "tests/tools/programs/results/report/report_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

constexpr int kSkipped = 77;  // exit code of check_page.sh where no browser is installed

class ReportInABrowser : public ReportTest {
 protected:
  // What check_page.sh finds in a page that should have these parts.
  ProcessResult CheckPage(const std::string& file, const std::vector<std::string>& parts) const {
    std::vector<std::string> command = {
        std::string(DRAPE_SOURCE_DIR) + "/tests/tools/programs/results/report/check_page.sh",
        Path(file)};
    command.insert(command.end(), parts.begin(), parts.end());
    return RunProcess(command);
  }
  // A fit and its drape, drapes of its posterior, branches, a chart, and a garment.
  std::vector<std::string> MakeFolders() const {
    const auto run = [&](const std::vector<std::string>& command) {
      const ProcessResult result = RunProcess(command);
      EXPECT_EQ(result.exit_code, 0) << result.err;
    };
    const std::string bin = DRAPE_BIN_DIR;
    run(SimulateCommand(
        {"--mesh=disc:300", "--steps=60", "--out=" + Path("drape"),
         "--start=" + std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json"}));
    run({kFit, "--images=" + Path("drape/silhouette.png"), "--fabric=" + kFabric, "--model=bayes",
         "--mesh=disc:150", "--coarse_mesh=disc:100", "--initial_stretch=1", "--initial_bend=0.5,1",
         "--initial_lifts=0.5,1", "--candidates_per_round=3,2,1", "--num_parameters=2",
         "--iterations=4,4,6", "--posterior_samples=4", "--posterior_iterations=4",
         "--elbo_samples=25", "--out=" + Path("fit")});
    Write("fit/fields.json", SmallFields().dump());  // as of a heterogeneous fit
    run({bin + "/drape_predict", "--fabric=" + Path("fit"), "--mesh=disc:120", "--draws=6",
         "--keep_meshes", "--steps=60", "--out=" + Path("predict")});
    run({bin + "/drape_equilibria", "--fabric=" + kFabric, "--mesh=disc:120", "--samples=4",
         "--steps=60", "--out=" + Path("branches")});
    AddResult("optimisers", "drape_compare_optimisers", {{"settings", {{"budget_rollouts", 10}}}});
    Write("optimisers/report.md", "# Gaps\n| method | gap |\n|---|---|\n| bobyqa | 0.5 |\n");
    Write("optimisers/chart.svg", ChartText());
    return {Path("fit"),      Path("drape"),      Path("predict"),
            Path("branches"), Path("optimisers"), AddGarment("garment")};
  }
  // With a script, which a browser does not run in a picture.
  static std::string ChartText() {
    return R"(<svg xmlns="http://www.w3.org/2000/svg" width="300" height="200">
      <script>document.documentElement.dataset.errors = "9"; throw 1</script>
      <text x="20" y="50">a chart</text></svg>)";
  }
};

TEST_F(ReportInABrowser, EveryPartIsFilledAndReadable) {
  std::vector<std::string> command = MakeFolders();
  command.insert(command.begin(), kReport);
  command.push_back("--out=" + Path("report.html"));
  const ProcessResult report = RunProcess(command);
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(Read(Path("report.html")), HasSubstr("class=\"fitted\""));
  const ProcessResult check =
      CheckPage("report.html", {"verdict", "images", "material", "outlines", "drape", "fields",
                                "posterior", "prediction", "spectrum", "studies", "provenance"});
  if (check.exit_code == kSkipped) GTEST_SKIP() << check.out;
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  EXPECT_THAT(check.out, testing::ContainsRegex("11 parts, 5 charts, 5 drapes"));
}

TEST_F(ReportInABrowser, FaultsOfAPageAreFound) {
  std::string page = Page({AddFit("fit", Json::object())});
  page.insert(page.find("<main>") + 6,
              "<section id=\"hollow\"></section><img alt=\"x\" src=\"http://127.0.0.1:9/x.png\">"
              "<div class=\"drapes\" data-drapes=\"7\"></div>"
              "<p style=\"color: #999; background: #777; width: 2000px\">faint and wide</p>");
  Write("page.html", page);
  const ProcessResult check = CheckPage("page.html", {"verdict", "posterior"});
  if (check.exit_code == kSkipped) GTEST_SKIP() << check.out;
  EXPECT_EQ(check.exit_code, 1) << check.err;
  for (const char* fault :
       {"no part posterior", "message of the browser: ", "empty part: hollow",
        "request: http:", "drape not drawn", "color-contrast", "wider than the window"})
    EXPECT_THAT(check.out, HasSubstr(fault));
}

}  // namespace
}  // namespace drape::test
