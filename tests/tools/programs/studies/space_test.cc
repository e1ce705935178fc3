// SPDX-License-Identifier: Apache-2.0
// drape_space as a user runs it.
#include "physics/material/material_io.h"
#include "solver/posterior/posterior_io.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kSpace = std::string(DRAPE_BIN_DIR) + "/drape_space";
const std::string kWool = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json";

class SpaceTool : public ToolFixture {
 protected:
  // Fabrics that differ by all stretch and by all bend entries.
  std::string AddPosterior(const std::string& name, double stretch, double bend,
                           double prior = 1.0) const {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kScales;
    posterior.specimens = 1;
    posterior.base = ReadMaterial(kWool).field;
    posterior.prior_sd = Eigen::Vector4d(prior, prior, 0.1, 0.1);
    posterior.mean = Eigen::Vector4d(stretch, bend, 0, 0);
    posterior.covariance = 0.01 * Eigen::Matrix4d::Identity();
    std::filesystem::create_directories(Path(name));
    WritePosterior(Path(name), posterior, "test");
    return Path(name);
  }
  ProcessResult Run(const std::string& posteriors,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {kSpace, "--posteriors=" + posteriors,
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

TEST_F(SpaceTool, WritesDistancesPopulationAndPictures) {
  const std::string folders =
      AddPosterior("linen", 0.0, 0.0) + "," + AddPosterior("denim", 0.1, 0.5) + "," +
      AddPosterior("silk", -0.2, -0.9) + "," + AddPosterior("twill", 0.7, 0.1);
  const std::string added = AddPosterior("found", 0.08, 0.52);
  const ProcessResult result = Run(folders, {"--new=" + added});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("4 fabrics by drape; the data determine 2 of 2"));
  EXPECT_THAT(result.out, testing::HasSubstr("denim"));
  const Json space = ReadJson(Path("out/space.json"));
  EXPECT_EQ(space["fabrics"].size(), 4u);
  EXPECT_EQ(space["tree"].size(), 3u);
  ASSERT_EQ(space["new"].size(), 1u);
  EXPECT_GT(space["new"][0]["probability_of_fabrics"][1].get<double>(), 0.5);
  // Two levels of six pairs, and the header.
  const std::string csv = Read(Path("out/distances.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  for (const char* picture : {"heat_map.png", "map.png", "textile_map.png"})
    EXPECT_GT(Read(Path(std::string("out/") + picture)).size(), 5000u) << picture;
}

TEST_F(SpaceTool, MistakesAreOneLine) {
  const std::string one = AddPosterior("one", 0, 0), two = AddPosterior("two", 1, 1);
  ExpectOneLineError(Run(one), "at least two fabrics");
  ExpectOneLineError(Run(one + "," + Path("none")), "none");
  ExpectOneLineError(Run(one + "," + AddPosterior("narrow", 0, 0, 0.5)), "prior_sd 0.5");
  ExpectOneLineError(Run(one + "," + two, {"--data=" + Path("")}), "found both");
  ExpectOneLineError(Run(one + "," + two, {"--recognise"}), "recognise");
  ExpectOneLineError(Run(one + "," + two, {"--new=" + Path("none.json")}), "none.json");
  ExpectOneLineError(RunProcess({kSpace, "--out=" + Path("out")}), "found neither");
  ExpectOneLineError(RunProcess({kSpace, "--data=" + Path(""), "--out=" + Path("out")}),
                     "material");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

}  // namespace
}  // namespace drape::test
