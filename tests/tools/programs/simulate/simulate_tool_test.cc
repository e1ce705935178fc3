// SPDX-License-Identifier: Apache-2.0
// The outputs that drape_simulate promises, from the real program.
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/obj_io.h"
#include "physics/simulation/rollout.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

constexpr int kVertices = 120;

class SimulateTool : public ToolFixture {
 protected:
  // The same rollout by the library.
  State ByTheLibrary(int steps) const {
    auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = kVertices}),
                                              CusickScene(), MakeLaw("smooth"));
    StepSolver solver(model);
    RolloutOptions options;
    options.steps = steps;
    return Rollout(solver, ReadMaterial(kFabric).field, model->RestState(), options).end;
  }
};

TEST_F(SimulateTool, WritesTheDrapeBitForBit) {
  const ProcessResult result = Simulate({"--dump_steps=0,2,3", "--backend=cpu"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, testing::HasSubstr("ok after 3 steps"));
  for (const int step : {2, 3}) {
    const State state = ReadState(Path("out/state_" + std::to_string(step) + ".json"), kVertices);
    const State expected = ByTheLibrary(step);
    EXPECT_EQ(state.x, expected.x) << step;
    EXPECT_EQ(state.v, expected.v) << step;
  }
  EXPECT_EQ(ReadState(Path("out/state_0.json"), kVertices).v.norm(), 0.0);
  EXPECT_EQ(ReadObjSurface(Path("out/drape.obj")).x, ByTheLibrary(3).x);
  EXPECT_EQ(Snapshot(Path("out")).size(), 6u);  // with summary, obj and png: nothing else
}

TEST_F(SimulateTool, SummarisesTheDrape) {
  ASSERT_EQ(Simulate({"--steps=20"}).exit_code, 0);
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "done");
  EXPECT_EQ(summary.at("status"), "ok");
  EXPECT_EQ(summary.at("steps"), 20);
  EXPECT_EQ(summary.at("mesh").at("vertices"), kVertices);
  EXPECT_EQ(summary.at("material"), "cotton_blue");
  EXPECT_EQ(summary.at("law"), "smooth");
  EXPECT_EQ(summary.at("provenance").at("build").at("drapefit"), DRAPE_VERSION);
  EXPECT_GT(summary.at("seconds").at("total"), 0.0);
  EXPECT_GT(summary.at("force_residual"), 1e-6);
  const GrayImage silhouette = ReadImage(Path("out/silhouette.png"));
  const double dc = DrapeCoefficient(CoverageArea(silhouette, Camera()), {});
  EXPECT_NEAR(summary.at("dc").get<double>(), dc, 1e-3);  // 8 bits a pixel
  EXPECT_GT(dc, 0.3);
  EXPECT_LT(dc, 0.95);
}

// Derivatives are by the 39 entries of one table.
TEST_F(SimulateTool, ACheckNeedsOneTable) {
  const Mesh mesh = MakeDisc({.target_vertices = kVertices});
  Material material =
      ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json");
  material.field.stretch.resize(mesh.num_faces(), material.field.stretch[0]);
  material.field.bend.resize(mesh.num_hinges(), material.field.bend[0]);
  WriteMaterialField(Path("field.json"), material, mesh);
  const std::string field = "--fabric=" + Path("field.json");
  ASSERT_EQ(Simulate({field}).exit_code, 0);
  ExpectOneLineError(RunProcess({kCheck, "--mesh=disc:120", field}),
                     "option 'fabric': found a material with a table for each element");
}

TEST_F(SimulateTool, GoesOnFromAState) {
  ASSERT_EQ(Simulate({"--dump_steps=2", "--out=" + Path("first")}).exit_code, 0);
  ASSERT_EQ(Simulate({"--steps=1", "--start=" + Path("first/state_2.json")}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/drape.obj")), Read(Path("first/drape.obj")));
}

TEST_F(SimulateTool, FindsTheRestByNewton) {
  ASSERT_EQ(Simulate({"--steps=40", "--time_step=0.1", "--solve=hybrid"}).exit_code, 0);
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("status"), "stable");
  EXPECT_LT(summary.at("force_residual"), 1e-9);
  const Json& stability = summary.at("stability");
  EXPECT_EQ(stability.at("stable"), true);
  const double lowest = stability.at("lowest_eigenvalues_per_s2").at(0);
  EXPECT_GT(lowest, 0.0);
  EXPECT_DOUBLE_EQ(stability.at("lowest_frequency_hz"), std::sqrt(lowest) / (2.0 * M_PI));
  EXPECT_EQ(ReadState(Path("out/state_rest.json"), kVertices).x,
            ReadObjSurface(Path("out/drape.obj")).x);
}

TEST_F(SimulateTool, TheDrapeCoefficientIsThatOfTheStandardsDisc) {
  ASSERT_EQ(Simulate({"--steps=2"}).exit_code, 0);
  EXPECT_TRUE(ReadJson(Path("out/summary.json")).at("dc").is_number());
  ASSERT_EQ(Simulate({"--steps=2", "--mesh=disc:200,radius=0.12"}).exit_code, 0);
  EXPECT_TRUE(ReadJson(Path("out/summary.json")).at("dc").is_null());
}

TEST_F(SimulateTool, SpecimenAndSupportAreOptions) {
  const ProcessResult result = Simulate({"--steps=2", "--specimen=0.36", "--support=0.2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("specimen_diameter_m"), 0.36);
  EXPECT_EQ(summary.at("support_diameter_m"), 0.2);
  EXPECT_EQ(summary.at("camera").at("width"), 308);
  EXPECT_EQ(ReadPngDiscs(Path("out/silhouette.png")), (DrapeDiscs{0.18, 0.1}));
  EXPECT_EQ(ReadObjDiscs(Path("out/drape.obj")), (DrapeDiscs{0.18, 0.1}));
  const GrayImage silhouette = ReadImage(Path("out/silhouette.png"));
  EXPECT_NEAR(summary.at("dc").get<double>(),
              DrapeCoefficient(CoverageArea(silhouette, CameraAbove({0.18, 0.1})), {0.18, 0.1}),
              1e-3);
  // A cloth of another size than the specimen has no drape coefficient, and its files say nothing.
  ASSERT_EQ(Simulate({"--steps=2", "--mesh=disc:200,radius=0.12"}).exit_code, 0);
  EXPECT_EQ(ReadPngDiscs(Path("out/silhouette.png")), std::nullopt);
  ExpectOneLineError(Simulate({"--support=0.4"}), "expected a support that is smaller");
}

TEST_F(SimulateTool, NewtonAloneDoesNotStartFromFlat) {
  for (const char* how : {"static", "hybrid"})
    ExpectOneLineError(Simulate({"--steps=0", std::string("--solve=") + how}), "not flat");
  ExpectOneLineError(Simulate({"--solve=static", "--dump_steps=0"}),
                     "solve = static, which takes no steps");
}

// Its hem is compressed and has no folds yet.
TEST_F(SimulateTool, SaysThatAFallingClothIsNotStable) {
  ASSERT_EQ(Simulate({"--steps=2", "--time_step=0.1", "--start=flat"}).exit_code, 0);
  const Json stability = ReadJson(Path("out/summary.json")).at("stability");
  EXPECT_EQ(stability.at("stable"), false);
  EXPECT_LT(stability.at("lowest_eigenvalues_per_s2").at(0), 0.0);
  EXPECT_TRUE(stability.at("lowest_frequency_hz").is_null());
}

// Without contact nothing keeps a state apart that begins crossed.
TEST_F(SimulateTool, SaysThatAClothPassesThroughItself) {
  ASSERT_EQ(Simulate({"--steps=0", "--start=flat", "--dump_steps=0"}).exit_code, 0);
  EXPECT_EQ(ReadJson(Path("out/summary.json")).at("self_intersections"), 0);
  State state = ReadState(Path("out/state_0.json"), kVertices);
  const Eigen::Vector3d first = state.x.head<3>();
  state.x.head<3>() = state.x.tail<3>();
  state.x.tail<3>() = first;
  WriteState(Path("crossed.json"), state);
  const ProcessResult result = Simulate({"--steps=0", "--start=" + Path("crossed.json")});
  EXPECT_THAT(result.out, testing::HasSubstr("passes through itself"));
  EXPECT_GT(ReadJson(Path("out/summary.json")).at("self_intersections"), 0);
  ExpectOneLineError(Simulate({"--steps=1", "--start=" + Path("crossed.json"), "--contact=self"}),
                     "crossed.json: found cloth that passes through itself near vertices");
}

TEST_F(SimulateTool, ContactOfTheClothWithItself) {
  ASSERT_EQ(Simulate({"--steps=2", "--contact=self"}).exit_code, 0);
  const Json contact = ReadJson(Path("out/summary.json")).at("contact");
  EXPECT_EQ(contact.at("smallest_self_gap_m"), Contact().range);  // nothing touches
  ExpectOneLineError(Simulate({"--steps=2", "--contact=self", "--backend=cuda"}),
                     "found cuda, expected cpu for contact of the cloth with itself");
  ExpectOneLineError(
      Simulate({"--steps=2", "--contact=self", "--thickness=0.01", "--mesh=disc:2000"}),
      "contact: found cloth of 10 mm and a range of 0.5 mm on edges of");
}

TEST_F(SimulateTool, ComparesWithAnImage) {
  ASSERT_EQ(Simulate({"--steps=20"}).exit_code, 0);
  std::filesystem::copy(Path("out/silhouette.png"), Path("image.png"));
  ASSERT_EQ(Simulate({"--steps=20", "--image=" + Path("image.png")}).exit_code, 0);
  const Json same = ReadJson(Path("out/summary.json")).at("image");
  EXPECT_GT(same.at("iou"), 0.995);  // grey levels of a PNG are whole numbers
  EXPECT_LT(same.at("mse"), 1e-5);
  EXPECT_LT(same.at("profile_rms_px"), 0.5);
  ASSERT_EQ(Simulate({"--steps=20", "--image=" + Path("image.png"), "--camera_cx=130.5"}).exit_code,
            0);
  const Json moved = ReadJson(Path("out/summary.json")).at("image");
  EXPECT_LT(moved.at("iou"), 0.985);
  EXPECT_GT(moved.at("profile_rms_px"), 1.0);
}

TEST_F(SimulateTool, TakesAConfigWithPathsBesideIt) {
  std::filesystem::copy(kFabric, Path("fabric.json"));
  const std::string config = Write("run.json", R"(// a comment
    {"mesh": "disc:120", "fabric": "fabric.json", "steps": 50, "dump_steps": [1, 2], "out": "there"})");
  const ProcessResult result =
      RunProcess({kSimulate, "--config=" + config, "--backend=cpu", "--steps", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ReadJson(Path("there/summary.json")).at("steps"), 2);  // the command line wins
  EXPECT_EQ(ReadState(Path("there/state_2.json"), kVertices).x, ByTheLibrary(2).x);
}

// A cloth whose hem is pulled in below the support, or that the camera does not see: what lies in
// the picture is no drape, and no number of it is one.
TEST_F(SimulateTool, WhatIsNoDrapeHasNoDrapeCoefficient) {
  Json state = Json::parse(R"({"x": [], "v": []})");
  const State rest = ByTheLibrary(0);
  for (int i = 0; i < kVertices; ++i) {
    const double x = rest.x[3 * i], y = rest.x[3 * i + 1];
    state["x"].push_back({0.4 * x, 0.4 * y, -0.01 * std::hypot(x, y)});
    state["v"].push_back({0, 0, 0});
  }
  const std::string start = "--start=" + Write("state.json", state.dump());
  const auto expect = [&](const std::vector<std::string>& more, const std::string& fault) {
    const ProcessResult result = Simulate(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, testing::HasSubstr("no drape (" + fault + "), force residual"));
    EXPECT_THAT(result.out, testing::Not(testing::HasSubstr("DC")));
    const Json summary = ReadJson(Path("out/summary.json"));
    EXPECT_EQ(summary.at("fault"), fault);
    EXPECT_TRUE(summary.at("dc").is_null());
    EXPECT_TRUE(summary.at("folds").is_null());
  };
  expect({start, "--steps=0"}, "tangled");
  expect({"--camera_scale=5000"}, "not all in the picture");
  expect({"--specimen=0.06", "--support=0.036", "--camera_scale=110"}, "too small in the picture");
  ASSERT_EQ(Simulate().exit_code, 0);
  EXPECT_TRUE(ReadJson(Path("out/summary.json")).at("fault").is_null());
}

// Forces that overflow are no success, and the program says so.
TEST_F(SimulateTool, AFailedRolloutDoesNotLookLikeSuccess) {
  Json far;
  for (int i = 0; i < kVertices; ++i) {
    far["x"].push_back({1e200, i * 1e200, -1e200});
    far["v"].push_back({0, 0, 0});
  }
  const std::string start = Write("far.json", far.dump());
  const ProcessResult result = Simulate({"--start=" + start, "--law=reference"});
  EXPECT_EQ(result.exit_code, 3) << result.out << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "failed");
  EXPECT_NE(summary.at("status"), "ok");
  EXPECT_EQ(summary.at("steps"), 0);
  EXPECT_THAT(result.out, testing::HasSubstr("no drape (its forces overflow)"));
  EXPECT_THAT(result.out, testing::Not(testing::HasSubstr("nan")));
}

// Positions that overflow at step 36, in the middle of a rollout.
TEST_F(SimulateTool, AFailedRolloutLeavesItsLastGoodState) {
  const std::string scene = Write("free.json", R"({"stretch": false, "bend": false})");
  Json fast;
  for (int i = 0; i < kVertices; ++i) {
    fast["x"].push_back({0.001 * i, 0.002 * i, 0});
    fast["v"].push_back({0, 0, -1e308});
  }
  const std::string start = "--start=" + Write("fast.json", fast.dump());
  const ProcessResult failed = Simulate({"--scene=" + scene, start, "--steps=50"});
  EXPECT_EQ(failed.exit_code, 3);
  EXPECT_THAT(failed.out + failed.err, testing::Not(testing::HasSubstr("nan")));
  EXPECT_EQ(ReadJson(Path("out/summary.json")).at("steps"), 35);
  const State reached = ReadState(Path("out/state_35.json"), kVertices);
  EXPECT_NEAR(reached.x[2], -35 * 0.05e308, 1e300);
  ASSERT_EQ(Simulate({"--scene=" + scene, start, "--steps=35", "--dump_steps=35",
                      "--out=" + Path("before")})
                .exit_code,
            0);
  EXPECT_EQ(Read(Path("out/state_35.json")), Read(Path("before/state_35.json")));
}

TEST_F(SimulateTool, CtrlCLeavesTheStateReached) {
  const ProcessResult result =
      Simulate({"--steps=1000000"}, {.interrupt_when = Path("out"), .interrupt_after = 0.3});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "cancelled");
  const int steps = summary.at("steps");
  EXPECT_GT(steps, 0);
  EXPECT_LT(steps, 1000000);
  const State reached = ReadState(Path("out/state_" + std::to_string(steps) + ".json"), kVertices);
  EXPECT_EQ(reached.x, ReadObjSurface(Path("out/drape.obj")).x);
  EXPECT_EQ(Snapshot(Path("out")).size(), 4u);
}

}  // namespace
}  // namespace drape::test
