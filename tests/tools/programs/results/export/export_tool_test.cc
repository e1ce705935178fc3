// SPDX-License-Identifier: Apache-2.0
// drape_export as a user runs it.
#include <Eigen/Dense>
#include <cmath>

#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kExport = std::string(DRAPE_BIN_DIR) + "/drape_export";
const std::string kViscose =
    std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/viscose_white.json";  // negative entries

class ExportTool : public ToolFixture {
 protected:
  ProcessResult Export(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {kExport};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
  // The exported file for `target` of cotton_blue.
  std::string ExportedFile(const std::string& target, const std::string& file) const {
    const ProcessResult result =
        Export({"--fabric=" + kFabric, "--to=" + target, "--starts=0", "--out=" + Path("out")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Path("out/" + file);
  }
  static double DrapeCoefficient(const std::string& obj) {
    const std::string text = RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_metrics", obj}).out;
    constexpr std::string_view kPercent = "drape coefficient [%]";
    return std::stod(text.substr(text.find(kPercent) + kPercent.size())) / 100.0;
  }
  // The mean drape coefficient of three starts of a disc of 300 vertices in the real program, by an
  // export for triangles of this edge [m]. how: options of drape_in_blender.py.
  double DcInBlender(const std::string& edge, const std::string& how) const {
    EXPECT_EQ(Simulate({"--mesh=disc:300", "--steps=0", "--out=" + Path("flat")}).exit_code, 0);
    EXPECT_EQ(Export({"--fabric=" + kFabric, "--to=blender", "--mesh=disc:1200", "--edge=" + edge,
                      "--out=" + Path("out")})
                  .exit_code,
              0);
    double dc = 0.0;
    for (const std::string start : {"1", "2", "3"}) {
      const std::string drape = Path("blender_" + start + ".obj");
      const ProcessResult run = RunProcess(
          {"/bin/sh", "-c",
           std::string("OMP_NUM_THREADS=1 blender -b --factory-startup --python '") +
               DRAPE_SOURCE_DIR + "/tests/tools/programs/results/export/drape_in_blender.py' -- '" +
               Path("out/blender_cloth.py") + "' '" + Path("flat/drape.obj") + "' '" + drape +
               "' --start=" + start + " " + how});
      EXPECT_THAT(run.out, testing::HasSubstr("MOVED")) << run.err;
      dc += DrapeCoefficient(drape) / 3.0;
    }
    return dc;
  }
};

TEST_F(ExportTool, WritesEveryTargetAndItsRoundTrip) {
  const ProcessResult result =
      Export({"--fabric=" + kFabric, "--to=all", "--mesh=disc:150", "--starts=1", "--edge=0.025",
              "--thickness=4e-4", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("record").at("name"), "cotton_blue");
  ASSERT_EQ(summary.at("targets").size(), 7u);
  for (const Json& target : summary.at("targets")) {
    const std::string file = target.at("file");
    EXPECT_TRUE(std::filesystem::exists(Path("out/" + file))) << file;
    EXPECT_THAT(result.out, testing::HasSubstr(file));
    EXPECT_EQ(target.at("round_trip").at("stable_pairs"), 1) << target;
    // The hinges of its coarse mesh would drape too softly.
    const std::string name = target.at("target");
    const bool has_hinges = name != "clo" && name != "json";
    const Json& unfitted = target.at("round_trip_unfitted");
    EXPECT_EQ(unfitted.is_null(), !has_hinges) << target;
    EXPECT_EQ(target.at("bend_factor") != 1.0, has_hinges) << target;
    if (!has_hinges) continue;
    EXPECT_GT(target.at("bend_factor"), 1.2) << target;
    EXPECT_LT(unfitted.at("dc_change"), -0.05) << target;
    EXPECT_NEAR(target.at("round_trip").at("dc_change"), 0.0, 0.03) << target;
  }
  EXPECT_THAT(result.out, testing::StartsWith("arcsim   DC "));
  EXPECT_THAT(result.out, testing::HasSubstr("not verified: not run in CLO"));
  EXPECT_THAT(result.out, testing::HasSubstr("by hinges of 25 mm, with "));
}

// The export says that nothing is fitted to a mesh where no drape is computed.
TEST_F(ExportTool, SaysThatRigiditiesAreNotFitted) {
  const auto lost = [&](const std::string& edge) {
    EXPECT_EQ(Export({"--fabric=" + kFabric, "--to=newton", "--starts=0", "--linear_at=rest",
                      "--edge=" + edge, "--out=" + Path("out")})
                  .exit_code,
              0);
    return ReadJson(Path("out/summary.json")).at("targets")[0].at("lost").dump();
  };
  EXPECT_THAT(lost("0.01"), testing::HasSubstr("--starts=0 leaves the rigidities as they are"));
  EXPECT_THAT(lost("0"), testing::Not(testing::HasSubstr("--starts=0")));
}

TEST_F(ExportTool, RaisesNegativeEntriesWhereAsked) {
  const ProcessResult result =
      Export({"--fabric=" + kViscose, "--min_relative_stiffness=0.1", "--to=arcsim", "--starts=0",
              "--linear_at=rest", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(ReadMaterial(Path("out/arcsim.json")).field.stretch[0].c[1][3], 0.0);
}

TEST_F(ExportTool, ArcsimDrapesToTheSameBytes) {
  const std::string exported = ExportedFile("arcsim", "arcsim.json");
  ASSERT_EQ(Simulate({"--out=" + Path("original")}).exit_code, 0);
  ASSERT_EQ(Simulate({"--fabric=" + exported, "--out=" + Path("exported")}).exit_code, 0);
  EXPECT_EQ(Read(Path("original/drape.obj")), Read(Path("exported/drape.obj")));
}

// The same points as in simulator_energies_test: edge_ke = 2·D/(h0 + h1).
TEST_F(ExportTool, NewtonsScriptMeasuresTheHinges) {
  if (RunProcess({"/bin/sh", "-c", "python3 -c 'import math'"}).exit_code != 0)
    GTEST_SKIP() << "needs python3";
  ExportedFile("newton", "newton.py");
  const Mesh mesh = MakeDisc({.target_vertices = 100});
  std::string points, uv, edges;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    Json point = Json::array(), place = Json::array();
    for (int k = 0; k < 3; ++k) point.push_back(mesh.rest_x[3 * i + k]);
    for (int k = 0; k < 2; ++k) place.push_back(mesh.uv(k, i));
    points += point.dump() + ",";
    uv += place.dump() + ",";
  }
  for (const Hinge& hinge : mesh.hinges)
    edges += Json{hinge.vertex[2], hinge.vertex[3], hinge.vertex[0], hinge.vertex[1]}.dump() + ",";
  Write("out/run.py", "import json, newton\nedges = [" + edges +
                          "[-1, 0, 1, 2]]\nprint(json.dumps(" + "newton.edge_ke([" + points +
                          "], edges, [" + uv + "])))\n" +
                          "print(json.dumps(newton.cloth_arguments('semi_implicit')))\n");
  const ProcessResult run =
      RunProcess({"/bin/sh", "-c", "cd " + Path("out") + " && python3 run.py"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json values = Json::parse(run.out.substr(0, run.out.find('\n')));
  ASSERT_EQ(values.size(), mesh.hinges.size() + 1);
  EXPECT_EQ(values.back(), 0.0);
  const Json linear = ReadJson(Path("out/summary.json")).at("record").at("linear");
  const double rows[] = {linear.at("bend_warp").at("value"), linear.at("bend_bias").at("value"),
                         linear.at("bend_weft").at("value")};
  for (size_t i = 0; i < mesh.hinges.size(); ++i) {
    const Hinge& hinge = mesh.hinges[i];
    const int first = hinge.direction < 1.0 ? 0 : 1;
    const double D = rows[first] + (hinge.direction - first) * (rows[first + 1] - rows[first]);
    const double expected = D * hinge.rest_length / hinge.rest_area;  // h0 + h1 = 2·area/l
    EXPECT_NEAR(values[i].get<double>() / expected, 1.0, 1e-9);
  }
}

// The angle of the chord [rad] of a chain of N links that is clamped at its first hinge, with a
// mass at each of the other ends. rigidity and mass by width; a: length of a link.
double ChainChord(double rigidity, double mass, double a, int N) {
  constexpr double kGravity = 9.81;  // of the scene in Blender
  Eigen::VectorXd angle = Eigen::VectorXd::Constant(N, 0.5);
  for (int iteration = 0; iteration < 200; ++iteration) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(N);
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(N, N);
    for (int i = 0; i < N; ++i) {
      const double before = i > 0 ? angle[i - 1] : 0.0, k = rigidity / a;
      force[i] -= k * (angle[i] - before);
      stiffness(i, i) += k;
      if (i > 0) {
        force[i - 1] += k * (angle[i] - before);
        stiffness(i - 1, i - 1) += k;
        stiffness(i, i - 1) -= k;
        stiffness(i - 1, i) -= k;
      }
      const double weight = mass * (N - i) * kGravity * a;
      force[i] += weight * std::cos(angle[i]);
      stiffness(i, i) += weight * std::sin(angle[i]);
    }
    angle += stiffness.ldlt().solve(force);
  }
  return std::atan2(angle.array().sin().sum(), angle.array().cos().sum());
}

// A cantilever of eight quads and their width of five in the real program.
TEST_F(ExportTool, BlenderBendsWithTheRigidity) {
  if (RunProcess({"/bin/sh", "-c", "command -v blender"}).exit_code != 0)
    GTEST_SKIP() << "needs blender (apt-get install blender)";
  constexpr double kRigidity = 1e-4, kDensity = 0.15, kLink = 0.0102;
  constexpr int kLinks = 8;
  Json tables;
  for (int r = 0; r < 6; ++r) tables["stretch"].push_back({100.0, 10.0, 100.0, 40.0});
  for (int r = 0; r < 3; ++r) tables["bend"].push_back(std::vector<double>(5, kRigidity));
  tables.update({{"format", "drapefit-material"},
                 {"version", 1},
                 {"convention", "mechanical"},
                 {"density", kDensity}});
  Write("sheet.json", tables.dump());
  ASSERT_EQ(Export({"--fabric=" + Path("sheet.json"), "--to=blender", "--starts=0",
                    "--linear_at=rest", "--out=" + Path("out")})
                .exit_code,
            0);
  Write("strip.py", R"py(
import math, sys
import bpy
folder, links, link = sys.argv[-3], int(sys.argv[-2]), float(sys.argv[-1])
bpy.ops.wm.read_factory_settings(use_empty=True)
points = [(i * link, j * link, 0.0) for i in range(-2, links + 1) for j in range(6)]
quads = [(6 * i + j, 6 * i + j + 6, 6 * i + j + 7, 6 * i + j + 1)
         for i in range(links + 2) for j in range(5)]
mesh = bpy.data.meshes.new("strip")
mesh.from_pydata(points, [], quads)
strip = bpy.data.objects.new("strip", mesh)
bpy.context.scene.collection.objects.link(strip)
strip.vertex_groups.new(name="held").add(
    [i for i, p in enumerate(points) if p[0] < 1e-9], 1.0, "REPLACE")
strip.select_set(True)
exec(open(folder + "/blender_cloth.py").read())
cloth = strip.modifiers["Cloth"]
cloth.settings.vertex_group_mass = "held"
cloth.settings.quality = 80
frames = 320
bpy.context.scene.frame_end = cloth.point_cache.frame_end = frames
chords = []
for frame in range(1, frames + 1):
    bpy.context.scene.frame_set(frame)
    if frame > 240:  # the rest of a slow oscillation
        at = strip.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh().vertices
        chords.append(math.atan2(-at[len(at) - 1].co.z, at[len(at) - 1].co.x))
print("CHORD", sum(chords) / len(chords))
)py");
  const ProcessResult run =
      RunProcess({"/bin/sh", "-c",
                  "blender -b --python '" + Path("strip.py") + "' -- '" + Path("out") + "' " +
                      std::to_string(kLinks) + " " + std::to_string(kLink)});
  const size_t at = run.out.find("CHORD ");
  ASSERT_NE(at, std::string::npos) << run.out << run.err;
  const double chord = std::stod(run.out.substr(at + 6));
  // All vertices have the same mass: a row of six the sixth of that of the sheet in six rows.
  const double area = (kLinks + 2) * 5 * kLink * kLink;
  const double row = kDensity * area / (kLinks + 3) / (5 * kLink);
  double low = 0.1 * kRigidity, high = 10.0 * kRigidity;
  while (high / low > 1.0 + 1e-6) {
    const double middle = std::sqrt(low * high);
    (ChainChord(middle, row, kLink, kLinks) > chord ? low : high) = middle;
  }
  RecordProperty("recovered_over_exported", std::to_string(low / kRigidity));
  EXPECT_NEAR(low / kRigidity, 1.0, 0.02);
}

// Discs of 300 vertices in the real program, from three starts: as the fabric drapes, where its own
// rigidities drape too softly there.
TEST_F(ExportTool, BlenderDrapesLikeTheFabric) {
  if (RunProcess({"/bin/sh", "-c", "command -v blender"}).exit_code != 0)
    GTEST_SKIP() << "needs blender (apt-get install blender)";
  const double fitted = DcInBlender("0.0165", "--held=0.09");
  const double fabric =
      ReadJson(Path("out/summary.json")).at("targets")[0].at("round_trip").at("dc_original");
  EXPECT_NEAR(fitted, fabric, 0.03);
  const double unfitted = DcInBlender("0", "--held=0.09");
  std::printf("DC of the fabric %.3f, in Blender %.3f, unfitted %.3f\n", fabric, fitted, unfitted);
  EXPECT_LT(unfitted, fabric - 0.06);
}

// The same numbers serve another scene: a disc that lies on a ball, held at its centre, without
// friction.
TEST_F(ExportTool, BlenderDrapesOnASphereLikeTheFabric) {
  if (RunProcess({"/bin/sh", "-c", "command -v blender"}).exit_code != 0)
    GTEST_SKIP() << "needs blender (apt-get install blender)";
  Write("ball.json", R"({"gravity": [0, 0, -9.81],
      "contact": {"obstacles": [{"sphere": {"centre": [0, 0, -0.102], "radius": 0.1016}}]},
      "handles": {"region": {"disc": {"radius": 0.02}}, "stiffness": 1e4}})");
  ASSERT_EQ(
      Simulate({"--mesh=disc:1200", "--scene=" + Path("ball.json"), "--solve=hybrid", "--steps=200",
                "--start=" + std::string(DRAPE_SOURCE_DIR) + "/configs/starts/six_waves.json",
                "--out=" + Path("ours")})
          .exit_code,
      0);
  const double fabric = DrapeCoefficient(Path("ours/drape.obj"));
  const double fitted = DcInBlender("0.0165", "--held=0.02 --sphere=0.1");
  const double unfitted = DcInBlender("0", "--held=0.02 --sphere=0.1");
  std::printf("DC of the fabric %.3f, in Blender %.3f, unfitted %.3f\n", fabric, fitted, unfitted);
  EXPECT_NEAR(fitted, fabric, 0.03);
  EXPECT_LT(unfitted, fabric - 0.03);
}

TEST_F(ExportTool, ScriptsPassTheNumbersOfTheirSolver) {
  if (RunProcess({"/bin/sh", "-c", "python3 -c 'import math'"}).exit_code != 0)
    GTEST_SKIP() << "needs python3";
  ExportedFile("newton,style3d", "newton.py");
  const ProcessResult run = RunProcess(
      {"/bin/sh", "-c",
       "cd '" + Path("out") +
           "' && python3 -c 'import json, newton as n, newton_style3d as s; print(json.dumps("
           "[n.FABRIC, n.cloth_arguments(), n.cloth_arguments(\"semi_implicit\"), "
           "s.tri_aniso_ke(), s.edge_aniso_ke()]))'"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json values = Json::parse(run.out);
  const auto number = [&](const char* key) { return values[0].at(key).get<double>(); };
  EXPECT_DOUBLE_EQ(values[1].at("tri_ke").get<double>(), number("mu"));
  EXPECT_DOUBLE_EQ(values[1].at("tri_ka").get<double>(), number("lambda"));
  EXPECT_DOUBLE_EQ(values[2].at("tri_ka").get<double>(), number("lambda") + number("mu"));
  EXPECT_DOUBLE_EQ(values[3][0].get<double>(), number("c11"));
  EXPECT_DOUBLE_EQ(values[3][2].get<double>(), number("shear"));
  EXPECT_DOUBLE_EQ(values[4][0].get<double>(), number("bend_weft") / 3.0);
  EXPECT_DOUBLE_EQ(values[4][1].get<double>(), number("bend_warp") / 3.0);
  EXPECT_DOUBLE_EQ(values[4][2].get<double>(), number("bend_bias") / 3.0);
}

TEST_F(ExportTool, BadInputIsOneLine) {
  const std::string out = "--out=" + Path("out");
  ExpectOneLineError(Export({"--fabric=" + kFabric, kFabric, "--to=clo", out}),
                     "expected --key=value");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=maya", out}), "maya");
  ExpectOneLineError(Export({"--fabric=" + kFabric, out}), "'to'");
  for (const std::string edge : {"0.001", "0.05"})
    ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=ppf", "--edge=" + edge, out}),
                       "expected 0 or 0.0029 to 0.029 m");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=clo", "--isotropic=both", out}),
                     "nearest");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=clo", out}), "found no material.json");
  ExpectOneLineError(Export({"--fabric=" + kViscose, "--to=clo", out}), "--min_relative_stiffness");
  ExpectOneLineError(Export({"--fabric=" + Path("none.json"), "--to=clo", out}), "none.json");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=clo", "--mesh=disc:x", out}), "disc:x");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=clo", "--mesh=strip:0.2x0.05x8", out}),
                     "expected disc:N");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

// drape_simulate --geometry, opened by the programs that read it.

class GeometryFiles : public ToolFixture {
 protected:
  static bool Runs(const std::string& command) {
    return RunProcess({"/bin/sh", "-c", command}).exit_code == 0;
  }
};

TEST_F(GeometryFiles, AreWrittenWithTheDrape) {
  ASSERT_EQ(Simulate({"--geometry=vtu", "--dump_steps=1,3"}).exit_code, 0);
  for (const char* name : {"drape.vtu", "drape.pvd", "state_1.vtu", "state_3.vtu"})
    EXPECT_TRUE(std::filesystem::exists(Path("out/") + name)) << name;
  EXPECT_THAT(Read(Path("out/drape.pvd")), testing::HasSubstr("state_3.vtu"));
  ExpectOneLineError(Simulate({"--geometry=fbx"}), "found 'fbx', expected one of vtu");
}

TEST_F(GeometryFiles, VtuIsReadByMeshio) {
  std::string python;
  for (const char* candidate : {"/usr/bin/python3", "python3"})
    if (Runs(std::string(candidate) + " -c 'import meshio'")) python = candidate;
  if (python.empty()) GTEST_SKIP() << "needs python3-meshio";
  ASSERT_EQ(Simulate({"--geometry=vtu"}).exit_code, 0);
  Write("read.py", R"py(
import sys
import meshio
drape = meshio.read(sys.argv[1] + "/drape.vtu")
points = [[float(c) for c in l.split()[1:]] for l in open(sys.argv[1] + "/drape.obj") if l.startswith("v ")]
assert drape.points.tolist() == points
faces = len(drape.cells[0].data)
assert drape.cells[0].type == "triangle"
assert drape.cell_data["strain [1]"][0].shape == (faces, 3)
assert drape.cell_data["stiffness [N/m]"][0].shape == (faces, 4)
print("EQUAL")
)py");
  const ProcessResult run =
      RunProcess({"/bin/sh", "-c", python + " '" + Path("read.py") + "' '" + Path("out") + "'"});
  EXPECT_EQ(run.out, "EQUAL\n") << run.err;
}

}  // namespace
}  // namespace drape::test
