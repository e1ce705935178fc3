// SPDX-License-Identifier: Apache-2.0
// drape_simulate on scenes other than the Cusick test, and drape_fit on mechanical tests.
#include <algorithm>
#include <utility>

#include "physics/material/material_io.h"
#include "physics/mesh/obj_io.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kSceneConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";

class SceneTool : public ToolFixture {
 protected:
  ProcessResult OnScene(const std::string& scene, const std::string& mesh,
                        const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options = {"--scene=" + kSceneConfigs + "scenes/" + scene + ".json",
                                        "--mesh=" + mesh, "--solve=static"};
    options.insert(options.end(), more.begin(), more.end());
    return Simulate(options);
  }
  Json Summary() const { return ReadJson(Path("out/summary.json")); }
};

TEST_F(SceneTool, AStripIsReportedAsItsTesterSeesIt) {
  ASSERT_EQ(OnScene("cantilever", "strip:0.07x0.005x42").exit_code, 0);
  const Json summary = Summary();
  EXPECT_EQ(summary.at("status"), "stable");
  EXPECT_FALSE(summary.contains("dc"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/silhouette.png")));
  const Json& strip = summary.at("strip");
  EXPECT_NEAR(strip.at("length_m"), 0.06, 1e-9);
  EXPECT_GT(strip.at("chord_deg"), 5.0);
  EXPECT_NEAR(std::hypot(strip.at("drop_m").get<double>(), strip.at("reach_m").get<double>()),
              strip.at("end_stretch").get<double>() * 0.06, 1e-9);
}

TEST_F(SceneTool, EachShippedSceneRuns) {
  ASSERT_EQ(OnScene("hanging_strip", "strip:0.3x0.03x30").exit_code, 0);
  EXPECT_GT(Summary().at("strip").at("end_stretch"), 1.0001);
  ASSERT_EQ(OnScene("uniaxial", "strip:0.2x0.05x20").exit_code, 0);
  EXPECT_GT(Summary().at("strip").at("end_stretch"), 1.005);
  ASSERT_EQ(OnScene("disc_clamped", "disc:300").exit_code, 0);
  EXPECT_GT(Summary().at("sag_m"), 1e-4);
  EXPECT_FALSE(Summary().contains("strip"));
}

// From the flat shape the cloth folds at once: a load path ends, and says where.
TEST_F(SceneTool, ASquareHangsFromTwoCorners) {
  const std::string square = "strip:0.2x0.2x20";
  const ProcessResult rest = OnScene("two_corners", square, {"--solve=hybrid", "--steps=200"});
  ASSERT_EQ(rest.exit_code, 0) << rest.out << rest.err;
  EXPECT_EQ(Summary().at("status"), "stable");
  EXPECT_GT(Summary().at("sag_m"), 0.15);
  const ProcessResult path = OnScene("two_corners", square);
  EXPECT_EQ(path.exit_code, 3);
  EXPECT_THAT(path.err, testing::HasSubstr("% of the load: no larger share converges"));
  EXPECT_THAT(path.err, testing::Not(testing::HasSubstr("nan")));
}

TEST_F(SceneTool, HeldCornersMustBeOfTheMesh) {
  const auto expect = [&](const std::string& held, const std::string& message) {
    const std::string scene = Write(
        "s.json", R"({"gravity": [0, 0, -9.81], "handles": {)" + held + R"(, "stiffness": 1000}})");
    ExpectOneLineError(Simulate({"--scene=" + scene, "--mesh=strip:0.1x0.02x10"}), message);
  };
  expect(
      R"("regions": [{"disc": {"radius": 0.011}}, {"disc": {"radius": 0.001, "centre": [1, 0]}}])",
      "s.json: key 'handles.regions[1]': found no vertex of strip:0.1x0.02x10 in it");
  expect(R"("vertices": [0, 4000])",
         "s.json: key 'handles.vertices[1]': found 4000, expected 0 to ");
}

TEST_F(SceneTool, CheckTakesAScene) {
  const ProcessResult result = RunProcess(
      {kCheck, "--scene=" + kSceneConfigs + "scenes/two_corners.json",
       "--fabric=" + kSceneConfigs + "fabrics/synthetic_wool.json", "--mesh=strip:0.2x0.2x20"});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("0 of "));
}

TEST_F(SceneTool, TheCusickSceneIsTheDefaultToTheBit) {
  ASSERT_EQ(Simulate({"--dump_steps=3"}).exit_code, 0);
  const std::string by_default = Read(Path("out/state_3.json"));
  ASSERT_EQ(
      Simulate({"--dump_steps=3", "--scene=" + kSceneConfigs + "scenes/cusick.json"}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/state_3.json")), by_default);
}

TEST_F(SceneTool, WhatASceneCannotHaveIsOneLine) {
  ExpectOneLineError(OnScene("uniaxial", "strip:0.1x0.05x20"),
                     "key 'load.region': found no edge of the hem of strip:0.1x0.05x20");
  ExpectOneLineError(OnScene("cantilever", "strip:0.07x0.01x21", {"--image=" + Path("a.png")}),
                     "option 'image': needs a drape over a support");
  ExpectOneLineError(Simulate({"--scene=" + Write("s.json", R"({"wind": 1})")}),
                     "s.json: unknown key 'wind', allowed: stretch bend gravity handles load");
  const std::string free = Write("free.json", R"({"gravity": [0, 0, -9.81]})");
  ExpectOneLineError(Simulate({"--scene=" + free, "--mesh=strip:0.1x0.02x10", "--solve=static"}),
                     "needs a scene that holds the cloth");
  ExpectOneLineError(Simulate({"--mesh=strip:0.08x0.02x10"}), "found all vertices held");
  ExpectOneLineError(Simulate({"--mesh=strip:0.1"}), "expected strip:LENGTHxWIDTHxALONG");
}

class MeshScene : public SceneTool {
 protected:
  // A scene with what the file of a mesh has, .8 mm below the cloth, and more keys of the entry.
  std::string SceneOn(const ClosedMesh& mesh, const std::string& more = "") const {
    WriteObj(Path("body.obj"), {mesh.x.reshaped(), mesh.triangles});
    return Write("s.json", R"({"gravity": [0, 0, -9.81], "handles": {"region": {"disc":
        {"radius": 0.02}}, "stiffness": 1000}, "contact": {"obstacles":
        [{"plane": {"normal": [0, 0, 1], "offset": -3}}, {"mesh": {"file": "body.obj")" +
                               more + "}}]}}");
  }
  ProcessResult On(const std::string& scene, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options = {"--scene=" + scene};
    options.insert(options.end(), more.begin(), more.end());
    return Simulate(options);
  }
  static ClosedMesh Moved(ClosedMesh mesh, double z) {
    mesh.x.row(2).array() += z;
    return mesh;
  }
};

TEST_F(MeshScene, TheShippedOneIsStable) {
  const std::vector<std::string> run = {"--fabric=" + kSceneConfigs + "fabrics/synthetic_wool.json",
                                        "--time_step=0.05", "--steps=100", "--solve=hybrid"};
  const ProcessResult rest = OnScene("three_lobes", "disc:400", run);
  ASSERT_EQ(rest.exit_code, 0) << rest.out << rest.err;
  EXPECT_EQ(Summary().at("status"), "stable");
  double lowest = 0.0;
  const ObjSurface drape = ReadObjSurface(Path("out/drape.obj"));
  for (Eigen::Index i = 2; i < drape.x.size(); i += 3) lowest = std::min(lowest, drape.x[i]);
  EXPECT_LT(lowest, -0.05);
  EXPECT_GT(Summary().at("contact").at("smallest_gap_m"), 0.0);
  EXPECT_LT(Summary().at("contact").at("smallest_gap_m"), 5e-4);
}

// In other units, in another place, and as the plane that its upper face is.
TEST_F(MeshScene, ScaleAndTranslationPlaceTheMesh) {
  ASSERT_EQ(On(SceneOn(Moved(MakeCube(1.0), -1.0 - 8e-4), R"(, "translation": [-0.5, -0.5, 0])"))
                .exit_code,
            0);
  const std::string drape = Read(Path("out/drape.obj"));
  ASSERT_EQ(
      On(SceneOn(MakeCube(1000.0), R"(, "scale": 0.001, "translation": [-0.5, -0.5, -1.0008])"))
          .exit_code,
      0);
  const ObjSurface scaled = ReadObjSurface(Path("out/drape.obj"));
  const std::string plane = Write("p.json", R"({"gravity": [0, 0, -9.81], "handles": {"region":
      {"disc": {"radius": 0.02}}, "stiffness": 1000},
      "contact": {"obstacles":
      [{"plane": {"normal": [0, 0, 1], "offset": -0.0008}}]}})");
  ASSERT_EQ(On(plane).exit_code, 0);
  const ObjSurface flat = ReadObjSurface(Path("out/drape.obj"));
  EXPECT_LT((scaled.x - flat.x).cwiseAbs().maxCoeff(), 1e-10);
  Write("first.obj", drape);
  EXPECT_LT((ReadObjSurface(Path("first.obj")).x - flat.x).cwiseAbs().maxCoeff(), 1e-10);
}

TEST_F(MeshScene, ARunIsRepeatedOnlyWithTheSameMesh) {
  const ClosedMesh cube = Moved(MakeCube(0.1), -0.1 - 8e-4);
  ASSERT_EQ(On(SceneOn(cube)).exit_code, 0);
  const std::string drape = Read(Path("out/drape.obj"));
  const std::vector<std::string> again = {kSimulate, "--config=" + Path("out/summary.json"),
                                          "--out=" + Path("again")};
  ASSERT_EQ(RunProcess(again).exit_code, 0);
  EXPECT_EQ(Read(Path("again/drape.obj")), drape);
  SceneOn(Moved(cube, -1e-4));
  ExpectOneLineError(RunProcess(again), "body.obj");
}

TEST_F(MeshScene, WhatIsNoSolidIsNamed) {
  const ClosedMesh cube = Moved(MakeCube(0.1), -0.1 - 8e-4);
  const auto expect = [&](const ClosedMesh& mesh, const std::string& message) {
    const ProcessResult result = On(SceneOn(mesh));
    ExpectOneLineError(result, message);
    EXPECT_THAT(result.err, testing::HasSubstr("s.json: key 'contact.obstacles[1].mesh.file': " +
                                               Path("body.obj")));
  };
  ClosedMesh bad = cube;
  bad.triangles.erase(bad.triangles.begin());
  expect(bad, "has no second face, expected a closed surface");
  bad = cube;
  std::swap(bad.triangles[0][0], bad.triangles[0][1]);
  expect(bad, "runs as in another face");
  bad = cube;
  for (auto& triangle : bad.triangles) std::swap(triangle[0], triangle[1]);
  expect(bad, "expected > 0: faces counter-clockwise as seen from outside");
  const int count = static_cast<int>(cube.x.cols());
  bad.x.resize(3, 2 * count);
  bad.x << cube.x, cube.x.array() - 0.03;
  bad.triangles = cube.triangles;
  for (const auto& [a, b, c] : cube.triangles)
    bad.triangles.push_back({a + count, b + count, c + count});
  expect(bad, "expected a surface that does not intersect itself");
  bad = cube;
  bad.x *= 1e6;
  expect(bad, "expected at most 100 m; scale is the length of its unit in metres");
  SceneOn(cube);
  std::filesystem::remove(Path("body.obj"));
  ExpectOneLineError(On(Path("s.json")), "key 'contact.obstacles[1].mesh.file': ");
  ExpectOneLineError(On(SceneOn(cube, R"(, "scale": 0)")),
                     "key 'contact.obstacles[1].mesh.scale': found 0, expected a number > 0");
  ExpectOneLineError(On(SceneOn(cube, R"(, "rotation": 0)")),
                     "unknown key 'contact.obstacles[1].mesh.rotation', allowed: file scale");
}

TEST_F(MeshScene, AStartInsideIsRefused) {
  ExpectOneLineError(On(SceneOn(Moved(MakeCube(0.1), -0.099))),
                     "mm in an obstacle, expected a start outside");
  // Deeper than distances are known.
  ExpectOneLineError(On(SceneOn(Moved(MakeCube(2.0), -1.0), R"(, "translation": [-1, -1, 0])")),
                     "found vertex 0 deep in an obstacle that is a mesh, expected a start outside");
}

TEST_F(MeshScene, CheckCoversIt) {
  const ProcessResult result =
      RunProcess({kCheck, "--scene=" + kSceneConfigs + "scenes/three_lobes.json",
                  "--fabric=" + kSceneConfigs + "fabrics/synthetic_wool.json", "--mesh=disc:300"});
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("0 of "));
  EXPECT_THAT(result.out, testing::HasSubstr("blocked by an obstacle"));
  // Steps that are so short that no move ends at the body.
  const ProcessResult in_contact = RunProcess(
      {kCheck, "--scene=" + kSceneConfigs + "scenes/three_lobes.json", "--time_step=0.001",
       "--fabric=" + kSceneConfigs + "fabrics/synthetic_wool.json", "--mesh=disc:300"});
  EXPECT_EQ(in_contact.exit_code, 0) << in_contact.out << in_contact.err;
  EXPECT_THAT(in_contact.out, testing::HasSubstr("tangent = adjoint"));
}

class TestFitTool : public ToolFixture {
 protected:
  ProcessResult Fit(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {
        kFit, "--num_parameters=2", "--out=" + Path("fit"),
        "--fabric=" + kSceneConfigs + "fabrics/synthetic_shirt.json"};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

TEST_F(TestFitTool, NeedsNoImage) {
  const ProcessResult result = Fit(
      {"--lab_tests=" + kSceneConfigs + "lab_tests/wool_cantilever_warp.json", "--density=0.27"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("wool_cantilever_warp"));
  EXPECT_EQ(ReadMaterial(Path("fit/material.json")).field.density, 0.27);
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(summary.at("lab_measurements").at(0).at("points").size(), 5u);
}

TEST_F(TestFitTool, BadTestsAreOneLine) {
  const std::string good =
      R"({"test": "cantilever", "direction": 0, "sigma": 1, "points": [{"length": 0.06, "angle": 41}]})";
  const auto with = [&](const std::string& part, const std::string& other) {
    std::string text = good;
    return "--lab_tests=" + Write("t.json", text.replace(text.find(part), part.size(), other));
  };
  ExpectOneLineError(Fit({with("sigma", "sgima")}), "t.json: unknown key 'sgima', allowed: test");
  ExpectOneLineError(Fit({with("0.06", "-0.06")}), "t.json: key 'points[0].length': found -0.06");
  ExpectOneLineError(Fit({with(R"([{"length": 0.06, "angle": 41}])", "[]")}), "at least one point");
  ExpectOneLineError(Fit({"--lab_tests=" + Path("*.none")}), "tests: '");
  ExpectOneLineError(Fit({}), "images: found no silhouette and no lab_tests");
  EXPECT_FALSE(std::filesystem::exists(Path("fit/summary.json")));
}

// A FAB file states 300 g/m2: it is used, --density wins with a note, and a strip needs no mass.
TEST_F(TestFitTool, TheMassOfATestFileIsUsed) {
  Json way = Json::array();
  for (int i = 0; i <= 100; ++i) way.insert(way.end(), {8.0 + 0.008 * i, 60.0 * i / 10});
  const Json file = {
      {"raw_data",
       {{"W", {{"S2", {{"width", 5}, {"samplesTree", Json::array({way})}}}}}, {"M", 300}}}};
  const std::string tests = "--lab_tests=" + Write("knit.json", file.dump());
  const auto run = [&](const std::vector<std::string>& options) {
    const ProcessResult result = Fit(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadJson(Path("fit/summary.json"));
  };
  const Json read = run({tests});
  EXPECT_EQ(ReadMaterial(Path("fit/material.json")).field.density, 0.3);
  EXPECT_THAT(read.at("notes").dump(), testing::HasSubstr("knit.json states 300 g/m2"));
  EXPECT_EQ(read.dump().find("if the assumed mass is right"), std::string::npos);
  const Json given = run({tests, "--density=0.15"});
  EXPECT_EQ(ReadMaterial(Path("fit/material.json")).field.density, 0.15);
  EXPECT_THAT(given.at("notes").dump(),
              testing::HasSubstr("but 150 g/m2 of option 'density' is used"));
  Json without = file;
  without["raw_data"].erase("M");
  Write("knit.json", without.dump());
  EXPECT_EQ(run({tests}).dump().find("if the assumed mass is right"), std::string::npos);
}

TEST_F(TestFitTool, UnitsOfOptionsAreNamed) {
  const std::string test = "--lab_tests=" + kSceneConfigs + "lab_tests/wool_cantilever_warp.json";
  ExpectOneLineError(Fit({test, "--density=150"}),
                     "option 'density': found '150', expected a number, 0 … 10 kg/m2; in g/m2 it "
                     "would be 0.15 kg/m2");
  ExpectOneLineError(Fit({test, "--specimen=30"}), "in cm it would be 0.3 m");
  ExpectOneLineError(Fit({test, "--support=7"}), "found 7 m, expected about 0.02 … 0.6 m; in cm");
}

TEST_F(TestFitTool, OneNameCannotStandForTwoTests) {
  const std::string test = kSceneConfigs + "lab_tests/wool_cantilever_warp.json";
  ExpectOneLineError(Fit({"--lab_tests=" + test + "," + test}), "a second measurement of the name");
}

}  // namespace
}  // namespace drape::test
