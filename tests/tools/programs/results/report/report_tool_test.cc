// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "losses/image/image.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/obj_io.h"
#include "tests/tools/programs/results/report/report_fixture.h"
#include "tools/programs/results/tables/outline_list.h"

namespace drape::test {
namespace {

using testing::HasSubstr;
using testing::Not;

// A picture that cannot be compressed.
RgbImage Noise(int width, int height) {
  RgbImage picture{width, height, std::vector<uint8_t>(size_t(3) * width * height)};
  unsigned state = 1;
  for (uint8_t& value : picture.rgb) value = (state = 1664525 * state + 1013904223) >> 24;
  return picture;
}

// A folder, whose name is a text as well, with a report and a table of a study.
TEST_F(ReportTest, TablesOfReportsAreKept) {
  const std::string folder = AddResult("a <b> \"c\" & d", "drape_speed", {{"rows", 1}});
  Write("a <b> \"c\" & d/report.md",
        "# A\ntext <\n| a | b |\n|---|---|\n| x | 1.5 |\n\n"
        "| a | b |\n|---|---|\n| **5<6** (1 px) | 0.4 [0.3, 1] |\n\xff\n");
  std::string rows = "# shared\na,\"b,c\"\n";
  for (int i = 0; i < 201; ++i) rows += "1,2\n";
  Write("a <b> \"c\" & d/runs.csv", rows);
  const std::string page = Page({folder});
  for (const char* part :
       {"<h3>A</h3>", "text &lt;", "<td class=\"number\">1.5</td>",
        "<td><strong>5&lt;6</strong> (1 px)</td>", "<td class=\"number\">0.4 [0.3, 1]</td>",
        ">b,c</th>", "and 1 more rows", "a &lt;b&gt; &#34;c&#34; &amp; d", "\ufffd"})
    EXPECT_THAT(page, HasSubstr(part));
}

// What a folder holds beside results: links to other files, pipes, files with a wrong name.
TEST_F(ReportTest, OnlyPicturesAreTakenIn) {
  const std::string folder = AddResult("out", "drape_speed", {{"rows", 1}});
  Write("secret.txt", "top secret");
  WritePng(RgbImage{2, 2, std::vector<uint8_t>(12, 100)}, Path("secret.png"));
  std::filesystem::create_symlink(Path("secret.png"), Path("out/link.png"));
  std::filesystem::create_symlink(Path("secret.txt"), Path("out/link.md"));
  ASSERT_EQ(mkfifo(Path("out/pipe.csv").c_str(), 0600), 0);
  Write("out/text.png", "\x89PNG top secret");
  Write("out/entity.svg", "<!DOCTYPE a [<!ENTITY b \"c\">]><svg>&b;</svg>");
  Write("out/page.svg", "<html>top secret</html>");
  const std::string page = Page({folder});
  for (const char* part :
       {"link.png: is a symbolic link", "link.md: is a symbolic link", "pipe.csv: is no file",
        "text.png: is no picture", "entity.svg: is no SVG", "page.svg: is no SVG"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, Not(HasSubstr("secret\"")));
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  std::filesystem::remove(Path("out/summary.json"));
  std::filesystem::create_symlink(Path("secret.txt"), Path("out/summary.json"));
  ExpectOneLineError(RunProcess({kReport, folder, "--out=" + Path("page.html")}),
                     "is a symbolic link");
}

TEST_F(ReportTest, FieldsAreDrawnOverTheCloth) {
  const std::string folder = AddFit("fit", Json::object());
  Json fields = SmallFields();
  Write("fit/fields.json", fields.dump());
  const std::string page = Page({folder});
  for (const char* part :
       {"<section id=\"fields\">", "<figure class=\"chart\">", "stretching: mean of c11 and c22",
        "<td class=\"number\">60</td>", "<td class=\"number\">1.5</td>"})
    EXPECT_THAT(page, HasSubstr(part));
  fields["hinges"] = Json::array({{0, 2, 1, 7}});
  for (const std::string& damaged : {fields.dump(), std::string("[1]"), std::string("{")}) {
    Write("fit/fields.json", damaged);
    EXPECT_THAT(Page({folder}), HasSubstr("fit/fields.json: "));
  }
}

// A page names an image that is no longer the one that was fitted.
TEST_F(ReportTest, AReplacedImageIsNamed) {
  Write("seen.png", "other bytes");
  const Json image = {{"name", "seen"},
                      {"file", Path("seen.png")},
                      {"camera",
                       {{"kind", "orthographic"},
                        {"width", 256},
                        {"height", 256},
                        {"cx", 127.5},
                        {"cy", 127.5},
                        {"px_per_m", 719.5}}}};
  const Json input = {{"path", Path("seen.png")}, {"sha256", std::string(64, '0')}};
  const std::string page =
      Page({AddFit("fit", {{"images", {image}}, {"provenance", {{"inputs", {input}}}}})});
  EXPECT_THAT(page, HasSubstr("<li>" + Path("seen.png") + " is not the file that was fitted"));
  EXPECT_THAT(page, HasSubstr("seen.png: is not the file that was fitted: it has changed since"));
}

// Texts count as well: notes, options and inputs without end.
TEST_F(ReportTest, LongTextsKeepThePageSmall) {
  Json many = Json::array(), images = Json::array();
  for (int i = 0; i < 20000; ++i) {
    many.push_back(std::string(100, 'x') + std::to_string(i));
    images.push_back({{"name", std::to_string(i)}, {"file", "none.png"}});
  }
  Json options = Json::object();
  for (int i = 0; i < 20000; ++i) options["key_" + std::to_string(i)] = std::string(300, 'y');
  const std::string page =
      Page({AddFit("fit", {{"notes", many},
                           {"images", images},
                           {"lab_measurements", {{{"name", "strip"}, {"points", images}}}},
                           {"provenance", {{"command", many}, {"options", options}}}})});
  EXPECT_LT(page.size(), 2000000U);
  EXPECT_THAT(page, HasSubstr("The first 96 of 20000 images."));
  EXPECT_THAT(page, HasSubstr("<li>and 19950 more</li>"));
  EXPECT_THAT(page, HasSubstr("Shape: no verdict"));
}

TEST_F(ReportTest, WarningsComeFirstAndNothingIsMarkup) {
  const std::string page = Page({AddFit(
      "fit", {{"verdict",
               {{"lamps",
                 {{"measurement", {{"grade", "good"}}},
                  {"shape", {{"grade", "do not use"}, {"reasons", {"<script>alert(1)</script>"}}}},
                  {"bending", {{"grade", "usable"}}}}}}},
              {"mean", {{"dc_image", 0.38}, {"dc_fit", 0.42}}},
              {"provenance", {{"command", "drape_fit --x=<i>"}}}})});
  EXPECT_THAT(page, HasSubstr("Shape: do not use"));
  EXPECT_THAT(page, HasSubstr("<div class=\"verdict good\"><p class=\"grade\">Measurement: good"));
  EXPECT_THAT(page, HasSubstr("<div class=\"verdict usable\"><p class=\"grade\">Bending: usable"));
  // The drape coefficient stands before the lamps, and outside the red one.
  EXPECT_LT(page.find("38.0 % and 42.0 %"), page.find("Measurement: good"));
  EXPECT_THAT(page, HasSubstr("<li>&lt;script&gt;alert(1)&lt;/script&gt;</li>"));
  EXPECT_THAT(page, HasSubstr("drape_fit --x=&lt;i&gt;"));
  EXPECT_THAT(page, HasSubstr("a&lt;b&gt;.json"));
  EXPECT_LT(page.find("Shape: do not use"), page.find("<section id=\"provenance\">"));
  EXPECT_THAT(page, Not(HasSubstr("%%")));
}

TEST_F(ReportTest, ProvenanceTellsHowToRepeat) {
  const std::string fit =
      AddFit("a fit",
             {{"provenance",
               {{"command", Json::array({"drape_fit", "--images=<a>.png", "--x=a'b c", "", "$y"})},
                {"options", {{"seed", 7}, {"split_seed", 8}, {"mesh", "disc:100"}}},
                {"inputs", Json::array({{{"path", "<a>.png"}, {"bytes", 12345}}})},
                {"build", {{"drapefit", "0.1.0"}, {"commit", "763e1da"}}}}}});
  const std::string page = Page({fit});
  EXPECT_THAT(
      page,
      HasSubstr("drape_fit &#39;--images=&lt;a&gt;.png&#39; &#39;--x=a&#39;\\&#39;&#39;b c&#39; "
                "&#39;&#39; &#39;$y&#39;"));
  EXPECT_THAT(page, HasSubstr("drape_fit &#39;--config=" + fit + "/summary.json&#39; --out=NEW"));
  EXPECT_THAT(page, HasSubstr("seed 7, split_seed 8"));
  EXPECT_THAT(page, HasSubstr("drapefit 0.1.0, commit 763e1da"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">12345</td>"));
}

TEST_F(ReportTest, MissingPartsAreLeftOut) {
  const std::string page = Page({AddFit("a", Json::object())});
  for (const char* part : {"images", "material", "posterior"})
    EXPECT_THAT(page, Not(HasSubstr("id=\"" + std::string(part) + "\"")));
  EXPECT_THAT(page, HasSubstr("Shape: no verdict"));
}

TEST_F(ReportTest, LaboratorySheetsAreShown) {
  const Json row = {{"name", "bending length"},
                    {"value", 1.5},
                    {"unit", "cm"},
                    {"low", 1.25},
                    {"high", 1.75},
                    {"text", "1.5"},
                    {"interval", "1.25 … 1.75"},
                    {"source", "from the prior"},
                    {"standard", "ISO <7>"}};
  const Json sheet = {{"title", "material"}, {"rows", {row}}};
  const std::string page =
      Page({AddFit("fit", {{"laboratory", {{"material", sheet}, {"photo", sheet}}}})});
  EXPECT_THAT(page, HasSubstr("1.25 … 1.75"));
  EXPECT_THAT(page, HasSubstr("ISO &lt;7&gt;"));
  EXPECT_THAT(page, HasSubstr("<td class=\"prior\">from the prior</td>"));
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

// What an instrument could not read is no number on the page either.
TEST_F(ReportTest, SheetsSayWhatIsBeyondTheInstrument) {
  const Json row = {{"name", "EMT"},
                    {"value", nullptr},
                    {"low", 31.25},
                    {"high", nullptr},
                    {"source", "from the prior"},
                    {"text", "> 100"},
                    {"interval", "31.2 … > 100"},
                    {"note", "beyond the instrument's range: > 100 %"}};
  const std::string page =
      Page({AddFit("fit", {{"laboratory", {{"material", {{"title", "M"}, {"rows", {row}}}}}}})});
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">&gt; 100</td>"
                              "<td class=\"number\">31.2 … &gt; 100</td>"));
  EXPECT_THAT(page, HasSubstr("from the prior; beyond the instrument"));
}

// A strip has no disc below it, which would hide it.
TEST_F(ReportTest, OnlyDrapesOverADiscHaveASupport) {
  const Mesh mesh = MakeDisc({.target_vertices = 100});
  for (const Json& summary :
       {Json{{"steps_wanted", 1}},
        Json{{"steps_wanted", 1}, {"specimen_diameter_m", 0.3}, {"support_diameter_m", 0.18}}}) {
    const std::string folder = AddResult("drape", "drape_simulate", summary);
    WriteObj(Path("drape/drape.obj"), mesh, mesh.rest_x);
    EXPECT_THAT(Page({folder}),
                HasSubstr(summary.contains("support_diameter_m") ? "\"support_m\":0.09,"
                                                                 : "\"support_m\":null,"));
  }
}

// A garment is shown in all its frames, with the body that wears it.
TEST_F(ReportTest, GarmentsMoveOnTheirBodies) {
  const std::string folder = AddGarment("skirt"), page = Page({folder});
  EXPECT_THAT(page, HasSubstr("\"name\":\"garment\",\"support_m\":null,"));
  EXPECT_THAT(page,
              HasSubstr("\"name\":\"height\",\"unit\":\"mm\",\"least\":0.0,\"most\":1000.0,"));
  EXPECT_THAT(page, HasSubstr("\"times\":[0.0,0.2,0.4,0.6,0.8]"));
  EXPECT_THAT(page, HasSubstr("\"bodies\":[{\"positions\":{"));
  Write("skirt/body.pc2", Read(Path("skirt/body.pc2")).substr(0, 100));
  EXPECT_THAT(Page({folder}), HasSubstr("body.pc2: expected 5 frames of "));
  Write("skirt/garment.pc2", "POINTCACHE2");
  EXPECT_THAT(Page({folder}), HasSubstr("garment.pc2: expected a point cache of "));
}

// Two garments are side by side, on one body; a page with little room has the last of its frames.
TEST_F(ReportTest, MotionsKeepThePageSmall) {
  const std::string page = Page({AddGarment("skirts", 2)});
  EXPECT_THAT(page, HasSubstr("data-drapes=\"0\" data-first=\"1\""));
  EXPECT_THAT(page, HasSubstr("\"body\":0}]]"));
  const std::string folder = AddGarment("skirt");
  for (const char* name : {"skirt/garment", "skirt/body"}) {
    const int32_t frames = 1500;
    std::string cache = Read(Path(name + std::string(".pc2")));
    const std::string rest = cache.substr(32 + 4 * (cache.size() - 32) / 5);
    cache.replace(28, 4, reinterpret_cast<const char*>(&frames), 4);
    for (int i = 5; i < frames; ++i) cache += rest;
    Write(name + std::string(".pc2"), cache);
  }
  const std::string small = Page({folder});
  EXPECT_LT(small.size(), 2000000U);
  EXPECT_THAT(small, testing::ContainsRegex("garment: [0-9]+ of 1500 frames are shown"));
  EXPECT_THAT(small, HasSubstr(",299.8],"));
  EXPECT_THAT(small, Not(HasSubstr("Left out")));
}

// Of optimisers, the first of the methods that solve most problems.
TEST_F(ReportTest, OptimisersHaveTheBestMethodInTheVerdict) {
  const std::string page =
      Page({AddResult("optimisers", "drape_compare_optimisers",
                      {{"settings", {{"budget_rollouts", 60}}},
                       {"methods",
                        {{{"name", "adam"}, {"solved_at_0.1", 0.25}},
                         {{"name", "lm"}, {"solved_at_0.1", 0.75}},
                         {{"name", "lm_patient"}, {"solved_at_0.1", 0.75}}}}})});
  EXPECT_THAT(page, HasSubstr("<dt>solves most problems to within 10 %</dt><dd>lm, 75 %</dd>"));
  EXPECT_THAT(page, HasSubstr("<dt>rollouts for each method and problem</dt><dd>60</dd>"));
}

// In place of the contact sheets of drape_predict and drape_equilibria.
TEST_F(ReportTest, DrapesFromAboveHaveColoursAndNumbers) {
  const std::string folder = AddResult("branches", "drape_equilibria",
                                       {{"vertices", 300},
                                        {"branches",
                                         {{{"seeds", {4, 9}},
                                           {"frequency", 2.0 / 3},
                                           {"dc", 0.4123},
                                           {"folds", 6},
                                           {"energy_J", -2.5e-3},
                                           {"stable", true},
                                           {"state", "branch_1.json"}}}}});
  const Eigen::VectorXd circle = Eigen::VectorXd::Constant(360, 0.12);
  WriteOutlines(Path("branches/outlines.json"), {{"branch 1, seed <4>", 0, 0.4123, 6, circle},
                                                 {"branch 2, seed 7", 8, 0.35, 7, circle}});
  const std::string page = Page({folder});
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">branch 1</th><td class=\"number\">2</td>"
                              "<td class=\"number\">67</td><td class=\"number\">41.2</td>"));
  EXPECT_THAT(page, HasSubstr("<span>branch 1, seed &lt;4&gt;</span><span>41.2 %, 6 nodes</span>"));
  EXPECT_THAT(page, HasSubstr("<li class=\"c0\">"));
  EXPECT_THAT(page, HasSubstr("<li class=\"c1\">"));     // 8 of 7 colours
  EXPECT_THAT(page, HasSubstr("d=\"M280 160L280 154"));  // 12 cm from the middle, which is at 160
  Write("branches/outlines.json", "{}");
  EXPECT_THAT(Page({folder}), HasSubstr("expected outlines of drapes"));
}

TEST_F(ReportTest, OfManyDrapesItSaysHowManyAreShown) {
  const std::string folder = AddResult("many", "drape_predict", {{"vertices", 300}});
  const Eigen::VectorXd circle = Eigen::VectorXd::Constant(120, 0.12);
  WriteOutlines(Path("many/outlines.json"),
                std::vector<ListedOutline>(100, {"specimen 1, face up", 0, 0.4, 6, circle}));
  const std::string page = Page({folder});
  EXPECT_THAT(page, HasSubstr("The first 96 of 100 drapes; outlines.json has all."));
}

// A page keeps its size; what finds no room is named, at the top and in its place.
TEST_F(ReportTest, StaysBelowItsSizeAndSaysWhatIsLeftOut) {
  const std::string folder = AddResult("out", "drape_predict", {{"vertices", 300}});
  const Mesh mesh = MakeDisc({.target_vertices = 3000});
  for (int i = 1; i <= 14; ++i)
    WriteObj(Path("out/draw_" + std::to_string(i) + ".obj"), mesh, mesh.rest_x);
  WritePng(Noise(200, 170), Path("out/large.png"));
  const std::string page = Page({folder});
  EXPECT_LT(page.size(), 2000000U);
  EXPECT_THAT(page, HasSubstr("12 of 14 drapes are shown"));
  EXPECT_THAT(page, Not(HasSubstr("Left out")));
  EXPECT_THAT(page, HasSubstr("\"name\":\"draw_12\""));  // not draw_14, which sorts before draw_2
  const std::string small = Page({folder}, 1.2);
  EXPECT_LT(small.size(), 1200000U);
  EXPECT_THAT(small, HasSubstr("Left out, to keep this page below 1.2 MB: "));
  EXPECT_THAT(small, HasSubstr("out/large.png has no room on this page"));
  EXPECT_LT(small.find("Left out"), small.find("<section"));
}

TEST_F(ReportTest, MeasurementsAndExportsAreTables) {
  Write("drapes.json", R"({"drapes": [
      {"file": "a<b>.png", "shape": {"dc": 0.412, "folds": 6, "radius_min_m": 0.1}, "area_m2": 0.05},
      {"file": "c.png", "error": "no cloth"}]})");
  Write("pair.json", R"({"a": {"file": "a.png", "shape": {"dc": 0.4}}, "b": {"file": "b.png",
      "shape": {"dc": 0.5}}, "raw": {"outline_rms_m": 0.0021}, "aligned": {"outline_rms_m": 0.001}})");
  Write("other.json", R"({"format": "drapefit-material"})");
  const std::string photo =
      AddResult("photo", "drape_photo",
                {{"photo", "p.jpg"}, {"dc", 0.456}, {"warnings", {"tilted by 9 degrees"}}});
  const std::string exported = AddResult(
      "export", "drape_export",
      {{"record",
        {{"name", "wool"},
         {"linear",
          {{"c11", {{"value", 150.0}, {"unit", "N/m"}, {"source", "from the prior"}}},
           {"bend_bias", {{"value", nullptr}, {"low", 3e-4}, {"source", "measured"}}},
           {"bend_warp",
            {{"value", 1.25e-5}, {"low", 1e-5}, {"high", 2e-5}, {"source", "measured"}}}}}}},
       {"targets",
        {{{"target", "clo"}, {"file", "w.jfab"}, {"status", "unverified"}, {"lost", {"c12"}}}}}});
  const std::string page = Page({Path("drapes.json"), Path("pair.json"), photo, exported});
  EXPECT_THAT(page,
              HasSubstr("<th scope=\"row\">a&lt;b&gt;.png</th><td class=\"number\">41.2</td>"));
  EXPECT_THAT(page, HasSubstr("not measured: no cloth"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">2.10</td><td class=\"number\">1.00</td>"));
  EXPECT_THAT(page, HasSubstr("<li>tilted by 9 degrees</li>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">45.6</td>"));
  EXPECT_THAT(page, HasSubstr("w.jfab"));
  EXPECT_LT(page.find("change of drape coefficient"), page.find("The linear record of wool"));
  EXPECT_THAT(
      page, HasSubstr("<th scope=\"row\">bending rigidity, warp</th><td class=\"number\">12.5</td>"
                      "<td class=\"number\">10 … 20</td><td>µN·m</td>"));
  EXPECT_THAT(page, HasSubstr("at least 300"));
  EXPECT_THAT(page, HasSubstr("<td class=\"prior\">from the prior</td>"));
  const std::string unknown = Page({AddResult(
      "unknown", "drape_export",
      {{"record",
        {{"name", "wool"},
         {"directions", {"softer", "stiffer"}},
         {"linear",
          {{"c11", {{"value", 150.0}, {"unit", "N/m"}, {"source", "from the prior"}}},
           {"bend_softer",
            {{"value", 1.25e-5}, {"low", 1e-5}, {"high", 2e-5}, {"source", "measured"}}}}}}}})});
  EXPECT_THAT(unknown, testing::AllOf(HasSubstr("bending rigidity, softer"),
                                      HasSubstr("tensile stiffness, stiffer (c11)"),
                                      testing::Not(HasSubstr("rigidity, warp"))));
  ExpectOneLineError(RunProcess({kReport, Path("other.json"), "--out=" + Path("page.html")}),
                     "has no results of drape_metrics");
}

// What drape_photo says of a photograph is on the pages of the photograph and of its fit, which has
// stored it; the overlay and the rest are there as long as the photograph's folder is.
TEST_F(ReportTest, PhotographsAreShownWithTheirFits) {
  const Json summary = {{"photo", "p<1>.jpg"},
                        {"silhouette", "silhouette.png"},
                        {"dc", 0.2734},
                        {"dc_sd", 0.0031},
                        {"blur_m", 0.0013},
                        {"marker_seen_share", 0.9},
                        {"warnings", {"tilted <by> 9"}}};
  const std::string photo = AddResult("photo", "drape_photo", summary);
  const auto fit_of = [&](const std::string& name, const std::string& file) {
    return AddFit(name, {{"verdict", {{"grade", "good"}}},
                         {"notes", {"silhouette: tilted <by> 9"}},
                         {"images",
                          {{{"name", "silhouette"},
                            {"file", file},
                            {"photograph", {{"dc", 0.2734}, {"dc_sd", 0.0031}}}}}}});
  };
  const std::string fit = fit_of("fit", photo + "/silhouette.png");
  const std::string own = Page({photo}), page = Page({fit}), both = Page({fit, photo});
  for (const std::string* each : {&own, &page}) {
    EXPECT_THAT(*each, HasSubstr("<dd>27.3 ± 0.3 %</dd>"));
    EXPECT_THAT(*each, HasSubstr("<td class=\"number\">27.3 ± 0.3</td>"));
    EXPECT_THAT(*each, HasSubstr("<td class=\"number\">90</td>"));
  }
  EXPECT_THAT(own, HasSubstr("<li>tilted &lt;by&gt; 9</li>"));
  const std::string warning = "<li>silhouette: tilted &lt;by&gt; 9</li>";
  EXPECT_LT(page.find(warning), page.find("<dl class=\"numbers\">"));
  EXPECT_EQ(page.find("tilted"), page.rfind("tilted"));  // once
  const std::string blur = "blur of the hem [mm]";
  EXPECT_EQ(both.find(blur), both.rfind(blur));  // once
  // Of another image in that folder, and of an image that is gone, only what the fit has stored.
  for (const std::string& file : {photo + "/overlay.png", Path("none/silhouette.png")}) {
    const std::string stored = Page({fit_of("stored", file)});
    EXPECT_THAT(stored, HasSubstr(warning));
    EXPECT_THAT(stored, HasSubstr("<dd>27.3 ± 0.3 %</dd>"));
    EXPECT_THAT(stored, Not(HasSubstr(blur)));
  }
}

// The overlay of a photograph has more bytes than a page has room.
TEST_F(ReportTest, LargePicturesAreShownSmaller) {
  const std::string photo = AddResult("photo", "drape_photo", {{"photo", "p.jpg"}});
  WritePng(Noise(1400, 1050), Path("photo/overlay.png"));
  EXPECT_GT(std::filesystem::file_size(Path("photo/overlay.png")), 2000000U);
  const std::string page = Page({photo});
  EXPECT_THAT(page, HasSubstr("src=\"data:image/jpeg;base64,"));
  EXPECT_THAT(page, Not(HasSubstr("has no room")));
}

TEST_F(ReportTest, RefusesOtherFolders) {
  const std::string out = "--out=" + Path("report.html");
  const std::string earlier = "<!doctype html>earlier";
  Write("report.html", earlier);
  std::filesystem::create_directories(Path("empty"));
  std::filesystem::create_directories(Path("broken"));
  Write("broken/summary.json", "{\"tool\": ");
  ExpectOneLineError(RunProcess({kReport, Path("none"), out}), "no such folder");
  ExpectOneLineError(RunProcess({kReport, Path("empty"), out}), "has no results");
  ExpectOneLineError(RunProcess({kReport, Path("broken"), out}), "summary.json");
  ExpectOneLineError(RunProcess({kReport, Path("report.html"), out}), "is not a folder");
  ExpectOneLineError(RunProcess({kReport, out}), "expected at least one folder");
  EXPECT_EQ(Read(Path("report.html")), earlier);
}

// Without its script, the page has all numbers.
TEST_F(ReportTest, TablesNeedNoScript) {
  std::string page = Page({AddFit(
      "fit", {{"spectrum", {{"singular_values", {3.0, 0.25}}, {"determined_directions", 1}}},
              {"parameters", {{"prior_sigma", 1.0}}}})});
  page.erase(page.find("<script"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">0.25</td><td>of the prior</td>"));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
}

// Samples of two fabrics, one of which has a fit.
nlohmann::json SamplesOfTwo() {
  using Json = nlohmann::json;
  const auto group = [](const char* fabric, const char* face, double dc, const Json& sd) {
    return Json{{"fabric", fabric},
                {"sample", ""},
                {"specimen", ""},
                {"face", face},
                {"pictures", 6},
                {"dc_percent", dc},
                {"dc_sd_percent", sd},
                {"n", 3},
                {"of", "specimens"},
                {"dc_low_percent", sd.is_null() ? sd : Json(dc - 2)},
                {"dc_high_percent", sd.is_null() ? sd : Json(dc + 2)},
                {"nodes", {6, 7, 8}}};
  };
  const auto picture = [](const char* file, const char* fabric) {
    return Json{{"file", file}, {"fabric", fabric}, {"customer", "A <b>"}, {"error", ""}};
  };
  return {{"samples",
           {{"pictures", {picture("x/x.png", "felt"), picture("y/y.png", "wool")}},
            {"groups",
             {group("felt", "up", 41, 1.25), group("felt", "", 42, 1.5),
              group("wool", "", 30, nullptr)}},
            {"differences", Json::array({{{"text", "the drape coefficient of felt is higher"}}})},
            {"notes", Json::array({"a note"})}}}};
}

TEST_F(ReportTest, CertificatesComeFirst) {
  const std::string samples = AddResult("photo", "drape_photo", SamplesOfTwo());
  const auto row = [](const char* key, const char* name, const char* source) {
    return Json{{"key", key},   {"name", name},        {"value", 1.2345},
                {"low", 1.0},   {"high", 2.0},         {"text", "1.234"},
                {"unit", "cm"}, {"interval", "1 … 2"}, {"source", source}};
  };
  const std::string fit =
      AddFit("fit", {{"verdict", {{"lamps", {{"shape", {{"grade", "usable"}}}}}}},
                     {"images", Json::array({{{"name", "x"}, {"file", "gone.png"}}})},
                     {"laboratory",
                      {{"material",
                        {{"title", "M"},
                         {"rows",
                          {row("bending_length_overall_cm", "bending length c", "measured"),
                           row("bending_overall_un_m", "bending rigidity B",
                               "measured, if the assumed mass is right"),
                           row("shear_n_per_m", "shear rigidity G", "from the prior")}}}}}}});
  const std::string page = Page({samples, fit});
  for (const char* part :
       {"<h3>Drape of felt</h3>", "<dd>A &lt;b&gt;</dd>", "face up", "42.0 ± 1.5", "3 specimens",
        "40.0 … 44.0", "6, 7 or 8", "<dd>1.23 cm (90 %: 1 … 2)</dd>",
        "<dd>1.23 cm (90 %: 1 … 2), if the assumed mass is right</dd>",
        "<li class=\"usable\">Shape: usable", "Not measured, but from the prior: shear rigidity G.",
        "30.0, sd unknown", "<li>The drape coefficient of felt is higher.</li>",
        "drapefit report: felt, wool", "<summary>From the prior, not measured (1)</summary>"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, Not(HasSubstr("none %")));
  EXPECT_LT(page.find("id=\"comparison\""), page.find("<details class=\"part\">"));
  EXPECT_LT(page.find("<details class=\"part\">"), page.find("Shape: usable</p>"));
}

// The pages of drape_report, opened in a browser.

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
         "--mesh=disc:120", "--coarse_mesh=disc:100", "--initial_stretch=1", "--initial_bend=0.5,1",
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
            Path("branches"), Path("optimisers"), AddGarment("garment", 2)};
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
  const ProcessResult check = CheckPage(
      "report.html", {"certificate", "verdict", "images", "material", "outlines", "drape", "fields",
                      "posterior", "prediction", "spectrum", "studies", "provenance"});
  if (check.exit_code == kSkipped) GTEST_SKIP() << check.out;
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  EXPECT_THAT(check.out, testing::ContainsRegex("12 parts, 5 charts, 6 drapes"));
}

// Two certificates and their comparison, each on one sheet.
TEST_F(ReportInABrowser, EachCertificateIsOneSheet) {
  Json samples = SamplesOfTwo();
  for (int i = 0; i < 12; ++i) samples["samples"]["notes"].push_back("a long note on this picture");
  Page({AddResult("photo", "drape_photo", samples)});
  const ProcessResult check = CheckPage("page.html", {"certificate", "comparison"});
  if (check.exit_code == kSkipped) GTEST_SKIP() << check.out;
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

TEST_F(ReportInABrowser, FaultsOfAPageAreFound) {
  std::string page = Page({AddFit("fit", Json::object())});
  page.insert(page.find("<main>") + 6,
              "<article class=\"certificate\"><p style=\"height: 400mm\">long</p></article>"
              "<section id=\"hollow\"></section><img alt=\"x\" src=\"http://127.0.0.1:9/x.png\">"
              "<div class=\"drapes\" data-drapes=\"7\"></div>"
              "<p style=\"color: #999; background: #777; width: 2000px\">faint and wide</p>");
  Write("page.html", page);
  const ProcessResult check = CheckPage("page.html", {"verdict", "posterior"});
  if (check.exit_code == kSkipped) GTEST_SKIP() << check.out;
  EXPECT_EQ(check.exit_code, 1) << check.err;
  for (const char* fault :
       {"pages, expected 1", "no part posterior", "message of the browser: ", "empty part: hollow",
        "request: http:", "drape not drawn", "color-contrast", "wider than the window"})
    EXPECT_THAT(check.out, HasSubstr(fault));
}

}  // namespace
}  // namespace drape::test
