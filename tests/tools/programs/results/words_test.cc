// SPDX-License-Identifier: Apache-2.0
// What a fit states of a number is what its files, its page, its exports and a space repeat.
#include <cmath>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

class Words : public ToolFixture {
 protected:
  // The silhouette of a drape of the shirt's tables with bending multiplied by `bend`.
  std::string AddDrape(const std::string& name, double bend) const {
    Material material = ReadMaterial(kFabric);
    material.field = Scaled(material.field, 1.0, bend);
    WriteMaterial(Path(name + ".json"), material);
    EXPECT_EQ(Simulate({"--mesh=disc:150", "--steps=60", "--time_step=0.1", "--solve=hybrid",
                        "--fabric=" + Path(name + ".json"), "--out=" + Path("drape_" + name)})
                  .exit_code,
              0);
    return "--images=" + Path("drape_" + name + "/silhouette.png");
  }
  // What the program printed.
  std::string Fit(const std::string& name, const std::string& data, const std::string& model,
                  const std::string& bend = "0.5,1,2") const {
    const ProcessResult result = RunProcess({kFit,
                                             data,
                                             "--fabric=" + kFabric,
                                             "--density=0.2",
                                             "--model=" + model,
                                             "--mesh=disc:150",
                                             "--search_mesh=disc:150",
                                             "--coarse_mesh=disc:100",
                                             "--simpler_models=false",
                                             "--initial_stretch=1",
                                             "--initial_bend=" + bend,
                                             "--initial_lifts=1",
                                             "--candidates_per_round=1",
                                             "--iterations=6",
                                             "--num_parameters=2",
                                             "--posterior_samples=2",
                                             "--posterior_rank=1",
                                             "--posterior_iterations=2",
                                             "--elbo_samples=25",
                                             "--threads=1",
                                             "--out=" + Path(name)});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
  LaboratorySheet Sheet(const std::string& name, const std::string& of = "material") const {
    return ReadSheet(Path(name), of).value();
  }
  // Fit, page and export of one fit.
  void ExpectSameWords(const std::string& name, const std::string& printed) const {
    SCOPED_TRACE(name);
    const Json summary = ReadJson(Path(name + "/summary.json"));
    const Json material = summary.at("laboratory").at("material");
    const std::string warp = summary.at("directions").at(0), weft = summary.at("directions").at(1);
    const LaboratoryRow bend = Sheet(name).of("bending_in_drape_un_m");
    ASSERT_EQ(RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_report", Path(name),
                          "--out=" + Path(name + ".html")})
                  .exit_code,
              0);
    std::string page = Read(Path(name + ".html"));
    for (const std::string system : {" class=\"si\"", " class=\"kes\""})  // of units
      for (std::size_t at = 0; (at = page.find(system, at)) != std::string::npos;)
        page.erase(at, system.size());
    for (const Json& row : material.at("rows")) {
      const std::string text = row.at("text"), interval = row.at("interval"),
                        source = row.at("source");
      EXPECT_EQ(interval.empty() && !text.starts_with("at "),
                source.starts_with("from the prior") || row.at("key") == "mass_g_per_m2");
      std::string cells = "<td class=\"number\">" + text + "</td><td class=\"number\">" + interval +
                          "</td><td>" + row.at("unit").get<std::string>() + "</td>";
      for (std::size_t at = 0; (at = cells.find("> ", at)) != std::string::npos;)
        cells.replace(at, 1, "&gt;");
      EXPECT_THAT(page, HasSubstr(cells)) << row;
    }
    const LaboratorySheet sheet = Sheet(name);
    for (const std::string& key :
         {std::string("bending_in_drape_un_m"), "bending_" + warp + "_un_m",
          "bending_" + weft + "_un_m", std::string("bending_overall_un_m"),
          std::string("shear_n_per_m")}) {
      const LaboratoryRow& row = sheet.of(key);
      const std::size_t at = printed.find("    " + row.name + " ");
      ASSERT_NE(at, std::string::npos) << key;
      const std::string line = printed.substr(at, printed.find('\n', at) - at);
      EXPECT_THAT(line, HasSubstr(" " + row.ValueText() + "  " + row.IntervalText()));
      EXPECT_THAT(line, testing::EndsWith(" " + row.source));
    }
    EXPECT_EQ(printed.find("ratio of B, stiffer over softer ") != std::string::npos,
              warp != "warp");
    if (bend.measured()) {
      EXPECT_THAT(printed, HasSubstr("Trust " + bend.Text()));
      EXPECT_THAT(page, HasSubstr("<dd>" + bend.Text().substr(bend.name.size() + 1) + "</dd>"));
    }
    const ProcessResult exported =
        RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_export", "--fabric=" + Path(name),
                    "--to=json", "--starts=0", "--linear_at=rest", "--out=" + Path(name + "_x")});
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    const Json record = ReadJson(Path(name + "_x/summary.json")).at("record").at("linear");
    for (const LaboratoryRow& row : Sheet(name, "linear").rows) {
      const Json& number = record.at(row.key);
      EXPECT_EQ(number.at("source"), row.source) << row.key;
      EXPECT_THAT(exported.out, HasSubstr(row.key + " " + number.at("text").get<std::string>()));
      EXPECT_EQ(number.at("low").is_null(), !row.interval || std::isinf(row.interval->low));
      if (number.at("low").is_null() || row.is_bound()) continue;
      EXPECT_NEAR(number.at("low").get<double>() / number.at("value").get<double>(),
                  row.interval->low / row.value, 1e-9);
    }
  }
};

TEST_F(Words, OfFiveFitsAreTheSameEverywhere) {
  const std::string usual = AddDrape("usual", 1.0);
  for (const char* name : {"three_0", "three_90"})
    Write(std::string(name) + ".json",
          Json{{"test", "cantilever"},
               {"direction", name == std::string("three_0") ? 0 : 90},
               {"sigma", 0.5},
               {"points",
                {{{"length", name == std::string("three_0") ? 0.06 : 0.048}, {"angle", 41.5}}}}}
              .dump());
  ExpectSameWords("one", Fit("one", usual, "homogeneous"));
  ExpectSameWords("bayes", Fit("bayes", usual, "bayes"));
  ExpectSameWords("soft", Fit("soft", AddDrape("soft", 0.4), "bayes"));
  ExpectSameWords("stiff", Fit("stiff", AddDrape("stiff", 300.0), "homogeneous", "4,8"));
  ExpectSameWords("strips",
                  Fit("strips", "--lab_tests=" + Path("three_0.json") + "," + Path("three_90.json"),
                      "homogeneous"));
  // A cloth that hardly drapes: a bound below its 300 times the start tables, and no green lamp.
  const LaboratoryRow stiff = Sheet("stiff").of("bending_in_drape_un_m");
  EXPECT_THAT(stiff.ValueText(), HasSubstr("at least "));
  EXPECT_LT(stiff.value, 1e6 * 300 * MeanBend(ReadMaterial(kFabric).field.bend[0]));
  EXPECT_EQ(ReadJson(Path("stiff/summary.json"))["verdict"]["lamps"]["bending"]["grade"], "usable");
  // Cantilevers are read back by their own sheet: B = W·g·c³, c half of the overhang.
  const double weft = 0.2 * 9.80665 * 27, warp = 0.2 * 9.80665 * std::pow(2.4, 3);
  EXPECT_NEAR(Sheet("strips").of("bending_weft_un_m").value, weft, 0.1);
  EXPECT_NEAR(Sheet("strips").of("bending_warp_un_m").value, warp, 0.1);
  EXPECT_NEAR(Sheet("strips").of("bending_overall_un_m").value, std::sqrt(weft * warp), 0.1);
  const ProcessResult space =
      RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_space",
                  "--posteriors=" + Path("bayes") + "," + Path("soft"), "--out=" + Path("space")},
                 {.charts = false});
  ASSERT_EQ(space.exit_code, 0) << space.err;
  const Json fabrics = ReadJson(Path("space/space.json")).at("fabrics");
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = i == 0 ? "bayes" : "soft";
    EXPECT_THAT(space.out, HasSubstr(Sheet(name).of("bending_in_drape_un_m").Text()));
    for (const LaboratoryRow& row : Sheet(name).rows) {
      const Json rows = fabrics.at(i).at("laboratory").at("rows");
      const auto same = std::find_if(rows.begin(), rows.end(),
                                     [&](const Json& each) { return each.at("key") == row.key; });
      ASSERT_NE(same, rows.end());
      EXPECT_EQ(same->at("text"), row.ValueText());
      EXPECT_EQ(same->at("source"), row.source);
    }
  }
}

}  // namespace
}  // namespace drape::test
