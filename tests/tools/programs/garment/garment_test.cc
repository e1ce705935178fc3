// SPDX-License-Identifier: Apache-2.0
// drape_garment as a user runs it, on a coarse skirt.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/garment/geometry_cache.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kGarment = std::string(DRAPE_BIN_DIR) + "/drape_garment";
const std::string kSkirt = std::string(DRAPE_SOURCE_DIR) + "/configs/garments/circle_skirt.json";

class GarmentTool : public ToolFixture {
 protected:
  ProcessResult Dress(const std::vector<std::string>& more) {
    std::vector<std::string> command = {kGarment, "--garment=" + kSkirt, "--body=mannequin:stand",
                                        "--edge=0.05"};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

TEST_F(GarmentTool, WritesCachesOfAllFramesOutsideOfTheBody) {
  const ProcessResult result =
      Dress({"--material=" + kFabric, "--seconds=0.12", "--out=" + Path("skirt")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"garment.obj", "body.obj", "sheet.png"})
    EXPECT_TRUE(std::filesystem::exists(Path("skirt") + "/" + name)) << name;
  const GeometryCache cloth = ReadGeometryCache(Path("skirt/garment.pc2")),
                      body = ReadGeometryCache(Path("skirt/body.pc2"));
  ASSERT_EQ(cloth.frames.size(), 4u);
  EXPECT_EQ(body.frames.size(), 4u);
  EXPECT_LT(cloth.frames[3].minCoeff(), cloth.frames[0].minCoeff() + 0.01);
  const nlohmann::json run = ReadJsonFile(Path("skirt/summary.json")).at("runs").at(0);
  EXPECT_EQ(run.at("status"), "done");
  EXPECT_GT(run.at("smallest_gap_m").get<double>(), 0.0);
  EXPECT_EQ(run.at("body_intersections"), 0);
}

TEST_F(GarmentTool, AResumedRunHasTheFramesOfOneRun) {
  const std::string material = "--material=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.16", "--out=" + Path("whole")}).exit_code, 0);
  ASSERT_EQ(Dress({material, "--seconds=0.08", "--out=" + Path("parts")}).exit_code, 0);
  ASSERT_EQ(
      Dress({material, "--seconds=0.16", "--resume=true", "--out=" + Path("parts")}).exit_code, 0);
  const auto whole = ReadGeometryCache(Path("whole/garment.pc2")).frames,
             parts = ReadGeometryCache(Path("parts/garment.pc2")).frames;
  ASSERT_EQ(whole.size(), 5u);
  EXPECT_EQ(whole, parts);
}

TEST_F(GarmentTool, BadInputIsOneLine) {
  const std::string out = "--out=" + Path("out"), material = "--material=" + kFabric;
  ExpectOneLineError(Dress({out}), "'material' and 'posterior'");
  ExpectOneLineError(Dress({out, material, "--draws=2"}), "'draws'");
  ExpectOneLineError(Dress({out, material, "--body=mannequin:fly"}), "fly");
  ExpectOneLineError(Dress({out, material, "--body=" + Path("body_%04d.obj")}), "body_");
  ExpectOneLineError(Dress({out, material, "--garment=" + kFabric}), "cotton_blue.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(GarmentTool, OtherSettingsCannotResume) {
  const std::string out = "--out=" + Path("out"), material = "--material=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.04", out}).exit_code, 0);
  ExpectOneLineError(Dress({material, "--seconds=0.08", "--friction=0.5", "--resume=true", out}),
                     "checkpoint.json");
}

// With the checksum made right again.
TEST_F(GarmentTool, ADamagedCheckpointIsRefused) {
  const std::string out = "--out=" + Path("out"), material = "--material=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.04", out}).exit_code, 0);
  const StoredFormat format = {"drapefit-garment-run", 1};
  const std::string path = Path("out/checkpoint.json");
  const Json good = ReadStoredJson(path, format);
  const auto expect_refused = [&](const std::string& key, const Json& value) {
    Json changed = good;
    changed[key] = value;
    WriteStoredJson(path, format, changed);
    ExpectOneLineError(Dress({material, "--seconds=0.08", "--resume=true", out}),
                       "checkpoint.json: key '" + key);
  };
  expect_refused("frame", -1);
  expect_refused("x", Json::array({1, 2}));
  expect_refused("v", "none");
  expect_refused("newton_steps", 1.5);
  expect_refused("smallest_gap", Json());
  expect_refused("settings", 3);
}

}  // namespace
}  // namespace drape::test
