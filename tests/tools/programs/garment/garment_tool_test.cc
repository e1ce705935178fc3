// SPDX-License-Identifier: Apache-2.0
// drape_garment as a user runs it, on a coarse skirt.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "physics/material/material_io.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/prediction/garment/body/body.h"
#include "solver/prediction/garment/pattern/pattern.h"
#include "solver/prediction/garment/wear_job.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/solver/prediction/garment/read_cache.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kGarment = std::string(DRAPE_BIN_DIR) + "/drape_garment";
const std::string kSkirt = std::string(DRAPE_SOURCE_DIR) + "/configs/garments/circle_skirt.json";

const std::string kDress = std::string(DRAPE_SOURCE_DIR) + "/configs/garments/tank_dress.json";

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
      Dress({"--fabric=" + kFabric, "--seconds=0.12", "--out=" + Path("skirt")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"garment.obj", "body.obj"})
    EXPECT_TRUE(std::filesystem::exists(Path("skirt") + "/" + name)) << name;
  const auto cloth = ReadCacheFrames(Path("skirt/garment.pc2")),
             body = ReadCacheFrames(Path("skirt/body.pc2"));
  ASSERT_EQ(cloth.size(), 4u);
  EXPECT_EQ(body.size(), 4u);
  EXPECT_LT(cloth[3].minCoeff(), cloth[0].minCoeff() + 0.01);
  const nlohmann::json run = ReadJsonFile(Path("skirt/summary.json")).at("runs").at(0);
  EXPECT_EQ(run.at("status"), "done");
  EXPECT_GT(run.at("smallest_gap_m").get<double>(), 0.0);
  EXPECT_EQ(run.at("body_intersections"), 0);
  EXPECT_EQ(run.at("self_intersections"), 0);
}

TEST_F(GarmentTool, APreviewSetsWhatIsNotGiven) {
  ASSERT_EQ(Dress({"--fabric=" + kFabric, "--seconds=0.04", "--preview", "--tolerance=0.02",
                   "--out=" + Path("skirt")})
                .exit_code,
            0);
  const Json summary = ReadJsonFile(Path("skirt/summary.json"));
  EXPECT_EQ(summary.at("time_step"), 0.04);
  EXPECT_EQ(summary.at("creep_speed"), 0.01);
  EXPECT_EQ(summary.at("friction_rounds"), 1);
  EXPECT_EQ(summary.at("tolerance"), 0.02);
}

TEST_F(GarmentTool, NoisyStartsDifferAndShareTheirFabric) {
  const std::vector<std::string> options = {"--fabric=" + kFabric, "--seconds=0.04", "--draws=2",
                                            "--start_noise=1e-3"};
  const auto run = [&](const std::string& name, const std::string& threads) {
    std::vector<std::string> all = options;
    all.push_back("--threads=" + threads);
    all.push_back("--out=" + Path(name));
    EXPECT_EQ(Dress(all).exit_code, 0);
    return std::array{ReadCacheFrames(Path(name + "/draw_1/garment.pc2")),
                      ReadCacheFrames(Path(name + "/draw_2/garment.pc2"))};
  };
  const auto runs = run("one", "1");
  EXPECT_EQ(runs, run("two", "2"));
  const Eigen::VectorXf between = runs[0][0] - runs[1][0];
  EXPECT_NEAR(between.norm() / std::sqrt(2e-6 * between.size()), 1.0, 0.1);
}

TEST_F(GarmentTool, AResumedRunHasTheFramesOfOneRun) {
  const std::string material = "--fabric=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.16", "--out=" + Path("whole")}).exit_code, 0);
  ASSERT_EQ(Dress({material, "--seconds=0.08", "--out=" + Path("parts")}).exit_code, 0);
  ASSERT_EQ(
      Dress({material, "--seconds=0.16", "--resume=true", "--out=" + Path("parts")}).exit_code, 0);
  const auto whole = ReadCacheFrames(Path("whole/garment.pc2")),
             parts = ReadCacheFrames(Path("parts/garment.pc2"));
  ASSERT_EQ(whole.size(), 5u);
  EXPECT_EQ(whole, parts);
}

// Without Newton steps the first time step fails, where the garment starts.
TEST_F(GarmentTool, AFailureNamesItsPlace) {
  WearSpec spec;
  spec.garment = kSkirt;
  spec.body = "mannequin:stand";
  spec.edge = 0.05;
  spec.seconds = 0.04;
  spec.wear.euler.max_iterations = 0;
  std::filesystem::create_directories(Path("failed"));
  const auto one_fabric = [](const ClothModel&) {
    return [](int) { return ReadMaterial(kFabric).field; };
  };
  const GarmentResult result = RunWearJob(spec, {.out = Path("failed")}, one_fabric, {});
  ASSERT_EQ(result.runs.at(0).wear.status, WearStatus::kFailed);
  EXPECT_EQ(WearSummary(result).at("status"), "failed");
  const std::string failure = result.runs[0].wear.reason;
  double x = 0.0, y = 0.0, z = 0.0;
  int vertex = 0;
  char panel[40] = "";
  ASSERT_EQ(std::sscanf(failure.c_str(),
                        "step 1, at 0.000 s, does not converge, even in 64 parts, near (%lf, %lf, "
                        "%lf) cm, vertex %d of garment.obj in panel '%39[^']'",
                        &x, &y, &z, &vertex, panel),
            5)
      << failure;
  const Pattern pattern = ReadPattern(kSkirt);
  const GarmentMesh mesh = MakeGarmentMesh(pattern, spec.edge);
  const Eigen::VectorXd start = ReadObjSurface(Path("failed/garment.obj")).x;
  ASSERT_LE(3 * vertex, start.size());
  EXPECT_LT((100.0 * start.segment<3>(3 * (vertex - 1)) - Eigen::Vector3d(x, y, z)).norm(), 0.1);
  const auto named = std::find_if(pattern.panels.begin(), pattern.panels.end(),
                                  [&](const Panel& p) { return p.name == panel; });
  ASSERT_NE(named, pattern.panels.end()) << panel;
  const auto k = named - pattern.panels.begin();
  EXPECT_GT(vertex, mesh.panel_begin[k]);
  EXPECT_LE(vertex, mesh.panel_begin[k + 1]);
}

TEST_F(GarmentTool, BadInputIsOneLine) {
  const std::string out = "--out=" + Path("out"), material = "--fabric=" + kFabric;
  ExpectOneLineError(Dress({out, material, "--draws=2"}), "'draws'");
  ExpectOneLineError(Dress({out, material, "--body=mannequin:fly"}), "fly");
  ExpectOneLineError(Dress({out, material, "--body=" + Path("body_%04d.obj")}), "body_");
  ExpectOneLineError(Dress({out, material, "--garment=" + kFabric}), "cotton_blue.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

// A body that is a thin rod beside the garment, or too thin to hold it.
TEST_F(GarmentTool, ABodyHasToMeetAndHoldTheGarment) {
  const auto write = [&](double x, double z, double length) {
    test::ClosedMesh rod = test::MakeBall(1.0, 2);
    rod.x = (Eigen::Vector3d(0.02, 0.02, 0.5 * length).asDiagonal() * rod.x).colwise() +
            Eigen::Vector3d(x, 0.0, z);
    WriteObj(Path("body_0000.obj"), ObjSurface{rod.x.reshaped(), rod.triangles});
  };
  const std::vector<std::string> options = {"--out=" + Path("out"), "--fabric=" + kFabric,
                                            "--body=" + Path("body_%04d.obj"), "--seconds=0.52",
                                            "--garment=" + kDress};
  std::vector<std::string> stated = options;
  for (const char* option :
       {"--body_up=z", "--body_scale=1", "--body_offset=0,0,0", "--body_grow=false"})
    stated.emplace_back(option);
  write(2.0, 1.1, 0.6);
  ExpectOneLineError(Dress(options), "are not those of a standing person");
  ExpectOneLineError(Dress(stated), "and a body about (2.00, ");
  const auto expect_failure = [&](const std::string& why) {
    const ProcessResult result = Dress(stated);
    EXPECT_EQ(result.exit_code, 3) << result.err;
    EXPECT_THAT(result.err, testing::HasSubstr(why));
    const Json summary = ReadJsonFile(Path("out/summary.json"));
    EXPECT_EQ(summary.at("status"), "failed");
    EXPECT_EQ(summary.at("body_front"), "-y");
  };
  write(0.0, 1.3, 0.6);
  expect_failure("has dropped off: all of it is below the body");
  write(0.0, 0.8, 2.6);
  expect_failure("has slid down: all of it by ");
}

// A thin rod that passes through a face of the skirt: to get out, the cloth would have to part.
TEST_F(GarmentTool, ABodyThatPassesThroughTheClothIsRefused) {
  test::ClosedMesh rod = test::MakeBall(1.0, 2);
  rod.x = (Eigen::Vector3d(0.015, 0.015, 0.3).asDiagonal() * rod.x).colwise() +
          Eigen::Vector3d(0.3, 0.0, 1.1);
  WriteObj(Path("body_0000.obj"), ObjSurface{rod.x.reshaped(), rod.triangles});
  ExpectOneLineError(
      Dress({"--out=" + Path("out"), "--fabric=" + kFabric, "--body=" + Path("body_%04d.obj"),
             "--body_up=z", "--body_scale=1", "--body_offset=0,0,0"}),
      "the body passes through");
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

// The sleeves wait for a T-pose; the arms hang down. Without its key the angle is guessed.
TEST_F(GarmentTool, RaisesArmsIntoSleevesOfAnotherPose) {
  const Mannequin mannequin(MotionKind::kStand);
  WriteObj(Path("body.obj"), ObjSurface{mannequin.PositionsInPose({}, 1), mannequin.triangles()});
  std::string shirt = Read(std::string(DRAPE_SOURCE_DIR) + "/configs/garments/t_shirt.json");
  const std::string angle = "\"arm_angle\": 80,";
  ASSERT_NE(shirt.find(angle), std::string::npos);
  shirt.replace(shirt.find(angle), angle.size(), "");
  WriteFileAtomically(Path("shirt.json"), shirt);
  const ProcessResult result =
      Dress({"--garment=" + Path("shirt.json"), "--body=" + Path("body.obj"), "--fabric=" + kFabric,
             "--seconds=0.08", "--preview", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ReadJsonFile(Path("out/summary.json")).at("runs").at(0).at("body_intersections"), 0);
}

TEST_F(GarmentTool, DressesTheBodyInSamplesOfAFit) {
  const std::string waves = std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json";
  ASSERT_EQ(RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_simulate", "--mesh=disc:100",
                        "--fabric=" + kFabric, "--start=" + waves, "--steps=40", "--time_step=0.1",
                        "--out=" + Path("drape")})
                .exit_code,
            0);
  const ProcessResult fit = RunProcess(
      {std::string(DRAPE_BIN_DIR) + "/drape_fit", "--images=" + Path("drape/silhouette.png"),
       "--fabric=" + kFabric, "--mesh=disc:100", "--coarse_mesh=disc:100", "--model=bayes",
       "--num_parameters=2", "--candidates_per_round=1", "--iterations=1", "--initial_stretch=1",
       "--initial_bend=1", "--initial_lifts=1", "--initial_steps=10", "--posterior_iterations=1",
       "--posterior_samples=4", "--threads=1", "--out=" + Path("fit")});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const std::vector<std::string> options = {"--fabric=" + Path("fit"), "--draws=2",
                                            "--seconds=0.08", "--out=" + Path("out")};
  const ProcessResult result = Dress(options);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto one = ReadCacheFrames(Path("out/draw_1/garment.pc2")),
             other = ReadCacheFrames(Path("out/draw_2/garment.pc2"));
  ASSERT_EQ(one.size(), 3u);
  ASSERT_EQ(other.size(), 3u);
  EXPECT_EQ(one[0], other[0]);
  EXPECT_NE(one[2], other[2]);
  EXPECT_EQ(ReadJsonFile(Path("out/summary.json")).at("draws"), 2);
  // Its table alone has no second sample.
  ExpectOneLineError(Dress({"--fabric=" + Path("fit/material_homogeneous.json"), "--draws=2",
                            "--out=" + Path("one")}),
                     "'draws'");
}

// A checkpoint knows its files by their contents.
TEST_F(GarmentTool, AChangedMaterialCannotResume) {
  const std::string fabric = Path("fabric.json"), material = "--fabric=" + fabric,
                    out = "--out=" + Path("out");
  std::filesystem::copy(kFabric, fabric);
  ASSERT_EQ(Dress({material, "--seconds=0.04", out}).exit_code, 0);
  std::filesystem::copy(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json",
                        fabric, std::filesystem::copy_options::overwrite_existing);
  ExpectOneLineError(Dress({material, "--seconds=0.08", "--resume=true", out}), "checkpoint.json");
}

// Another order of the same numbers is another cloth; another place of the same files is not.
TEST_F(GarmentTool, AnExchangeOfWarpAndWeftCannotResumeAndAMoveCan) {
  const std::string out = "--out=" + Path("out"), more = "--seconds=0.08";
  ASSERT_EQ(Dress({"--fabric=" + kFabric, "--seconds=0.04", out}).exit_code, 0);
  Json fabric = ReadJsonFile(kFabric);
  std::swap(fabric.at("bend").at(0), fabric.at("bend").at(2));
  const std::string turned = Path("turned.json"), copy = Path("copy.json");
  WriteFileAtomically(turned, fabric.dump());
  ExpectOneLineError(Dress({"--fabric=" + turned, more, "--resume=true", out}), "checkpoint.json");
  std::filesystem::copy(kFabric, copy);
  std::filesystem::copy(kSkirt, Path("skirt.json"));
  const ProcessResult moved =
      RunProcess({kGarment, "--garment=" + Path("skirt.json"), "--body=mannequin:stand",
                  "--edge=0.05", "--fabric=" + copy, more, "--resume=true", out});
  EXPECT_EQ(moved.exit_code, 0) << moved.err;
}

TEST_F(GarmentTool, OtherSettingsCannotResume) {
  const std::string out = "--out=" + Path("out"), material = "--fabric=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.04", out}).exit_code, 0);
  ExpectOneLineError(Dress({material, "--seconds=0.08", "--friction=0.5", "--resume=true", out}),
                     "checkpoint.json");
}

// With the checksum made right again.
TEST_F(GarmentTool, ADamagedCheckpointIsRefused) {
  const std::string out = "--out=" + Path("out"), material = "--fabric=" + kFabric;
  ASSERT_EQ(Dress({material, "--seconds=0.04", out}).exit_code, 0);
  const StoredFormat format = {"drapefit-garment-run", 3};
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
