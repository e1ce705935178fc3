// SPDX-License-Identifier: Apache-2.0
// drapefit photo.jpg --mass=…, all of its programs run, on a rendered photograph of a known drape.
#include <gmock/gmock.h>

#include "physics/material/material_io.h"
#include "tests/losses/photo/rendered/photo_file.h"
#include "tests/losses/photo/rendered/photo_trial.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kDrapefit = std::string(DRAPE_BIN_DIR) + "/drapefit";
const std::string kFabrics = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/";

class ShortWay : public ToolFixture {
 protected:
  // A telephone's picture of the drape.
  std::string AddPhoto(const KnownDrape& drape) const {
    PhotoScene scene;
    scene.tilt = {0.05, 0.03};
    scene.eye = {0.05, -0.04, 1.0};
    const std::string path = Path("photo.jpg");
    WritePhotoFile(scene, RenderPhoto(scene, {{&drape.mesh, drape.x}}), path);
    return path;
  }
  // fit_bayes.json with small meshes, few initial guesses and few samples.
  std::string AddConfig(const char* mesh = "disc:200") const {
    return Write("fit.json", Json({{"fabric", kFabrics + "synthetic_shirt.json"},
                                   {"model", "bayes"},
                                   {"mesh", mesh},
                                   {"coarse_mesh", "disc:100"},
                                   {"initial_stretch", {1}},
                                   {"initial_bend", {0.25, 0.5, 1, 2}},
                                   {"initial_lifts", {0.8, 1}},
                                   {"num_parameters", "2"},
                                   {"posterior_samples", 4},
                                   {"posterior_rank", 2},
                                   {"candidates_per_round", {3, 2, 1}},
                                   {"iterations", {4, 4, 6}},
                                   {"elbo_samples", 25},
                                   {"min_relative_stiffness", 0.1}})
                                 .dump());
  }
};

TEST_F(ShortWay, LeadsFromAPhotographToAReport) {
  const KnownDrape& wool = Wool();
  const double mass = 1000 * ReadMaterial(kFabrics + "synthetic_wool.json").field.density;
  const ProcessResult result =
      RunProcess({kDrapefit, AddPhoto(wool), "--mass=" + std::to_string(mass),
                  "--fit_config=" + AddConfig(), "--draws=2", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  const Json photo = ReadJson(Path("out/photo/summary.json"));
  EXPECT_NEAR(100 * photo["dc"].get<double>(), 100 * wool.coefficient, 0.5);
  const Json fit = ReadJson(Path("out/fit/summary.json"));
  EXPECT_EQ(fit["images"][0]["camera"]["kind"], "pinhole");
  EXPECT_EQ(fit["images"][0]["photograph"]["dc_sd"], photo["dc_sd"]);
  EXPECT_NEAR(100 * fit["images"][0]["metrics"]["dc_fit"].get<double>(), 100 * wool.coefficient, 3);
  EXPECT_NE(Read(Path("out/predict/summary.json")), "");
  const std::string page = Read(Path("out/report.html"));
  EXPECT_THAT(page, HasSubstr("<svg viewBox"));
  EXPECT_THAT(page, HasSubstr("data:image/png;base64"));
  EXPECT_THAT(page, HasSubstr("class=\"image\""));
  EXPECT_THAT(page, HasSubstr("class=\"fitted\""));
}

// A table of samples leads to a certificate. The same command runs nothing again.
TEST_F(ShortWay, LeadsFromSamplesToCertificates) {
  std::filesystem::rename(AddPhoto(Wool()), Path("a.jpg"));
  std::filesystem::copy_file(Path("a.jpg"), Path("b.jpg"));
  const std::string table = Write("samples.csv",
                                  "file;fabric;specimen;face;mass\na.jpg;red wool;1;up;180\n"
                                  "b.jpg;red wool;1;down;180\n");
  const std::vector<std::string> command = {
      kDrapefit, table, "--fit_config=" + AddConfig("disc:100"), "--out=" + Path("out")};
  const ProcessResult result = RunProcess(command);
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  EXPECT_THAT(result.out, HasSubstr("samples.csv#red wool'"));
  EXPECT_THAT(result.out, HasSubstr(" --density=0.18 "));
  const Json fit = ReadJson(Path("out/fit/summary.json"));
  EXPECT_EQ(fit["images"].size(), 2U);
  const std::string page = Read(Path("out/report.html"));
  for (const char* part : {"<h3>Drape of red wool</h3>", "face down", "sd unknown", "5 cm",
                           "<image width=", "bending length c, overall"})
    EXPECT_THAT(page, HasSubstr(part));
  const ProcessResult again = RunProcess(command);
  EXPECT_THAT(again.out, HasSubstr("done before: drapefit photo"));
  EXPECT_THAT(again.out, HasSubstr("done before: drapefit report"));
  Write("samples.csv", "file,fabric\na.jpg,red wool\n");
  ExpectOneLineError(RunProcess(command), "has no mass of the fabric 'red wool'");
}

// A photograph that is refused ends the run with its line, and the picture that shows why.
TEST_F(ShortWay, EndsAtAPhotographThatIsRefused) {
  PhotoScene scene;
  scene.width = 800;
  scene.height = 600;
  scene.falloff = 0;
  const std::string path = Path("empty.jpg");
  WritePhotoFile(scene, RenderPhoto(scene, {}), path);
  ExpectOneLineError(RunProcess({kDrapefit, path, "--mass=150", "--warp=9x"}),
                     "option 'warp': found '9x'");
  const ProcessResult result =
      RunProcess({kDrapefit, path, "--mass=150", "--warp=right", "--out=" + Path("out")});
  EXPECT_THAT(result.out, HasSubstr(" --warp=right "));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("empty.jpg: no cloth: "));
  EXPECT_TRUE(std::filesystem::exists(Path("out/photo/refused.png")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/fit")));
}

}  // namespace
}  // namespace drape::test
