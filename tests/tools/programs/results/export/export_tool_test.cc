// SPDX-License-Identifier: Apache-2.0
// drape_export as a user runs it.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <cmath>
#include <sstream>

#include "physics/material/material_io.h"
#include "physics/mesh/disc.h"
#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/variational_fit.h"
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
    EXPECT_NEAR(target.at("round_trip").at("dc_change"), 0.0, 0.05) << target;  // of one start
  }
  EXPECT_THAT(result.out, testing::HasSubstr("not verified: not run in CLO"));
  EXPECT_THAT(result.out, testing::HasSubstr("by hinges of 25 mm, with "));
}

// Where no drape is computed nothing is fitted to a mesh, and the export says so.
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
  ASSERT_EQ(Simulate({"--mesh=disc:300", "--steps=0", "--out=" + Path("flat")}).exit_code, 0);
  const auto drape_there = [&](const std::string& edge) {
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
               "' --held=0.09 --start=" + start});
      EXPECT_THAT(run.out, testing::HasSubstr("MOVED")) << run.err;
      const std::string measured =
          RunProcess({std::string(DRAPE_BIN_DIR) + "/drape_metrics", drape}).out;
      constexpr std::string_view kPercent = "drape coefficient [%]";
      dc += std::stod(measured.substr(measured.find(kPercent) + kPercent.size())) / 300.0;
    }
    return dc;
  };
  const double fitted = drape_there("0.0165");
  const double fabric =
      ReadJson(Path("out/summary.json")).at("targets")[0].at("round_trip").at("dc_original");
  EXPECT_NEAR(fitted, fabric, 0.03);
  const double unfitted = drape_there("0");
  std::printf("DC of the fabric %.3f, in Blender %.3f, unfitted %.3f\n", fabric, fitted, unfitted);
  EXPECT_LT(unfitted, fabric - 0.06);
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

// What drape_export writes for statisticians, as they read it.

const std::string kExportSamples = std::string(DRAPE_BIN_DIR) + "/drape_export";

const std::string kPackage = std::string(DRAPE_SOURCE_DIR) + "/tools/python/drapefit";

class StatisticsTest : public ToolFixture {
 protected:
  ProcessResult Export(const std::vector<std::string>& more) const {
    std::vector<std::string> command = {kExportSamples};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  }
};

// Two factors on stretch and on bend, and a specimen.
StoredPosterior Scales() {
  StoredPosterior posterior;
  posterior.fabric = ParameterTying::kScales;
  posterior.specimens = 1;
  posterior.base = ReadMaterial(kFabric).field;
  posterior.prior_sd = Eigen::VectorXd::Constant(4, 0.5);
  posterior.mean = Eigen::VectorXd::LinSpaced(4, -0.3, 0.3);
  posterior.covariance = Eigen::MatrixXd::Constant(4, 4, 0.01);
  posterior.covariance.diagonal() = Eigen::VectorXd::LinSpaced(4, 0.02, 0.08);
  return posterior;
}

std::string PythonWith(const std::string& modules) {
  for (const std::string python : {"/usr/bin/python3", "python3"})
    if (RunProcess({"/bin/sh", "-c", python + " -c 'import " + modules + "'"}).exit_code == 0)
      return python;
  return "";
}

// As a statistician opens it: the file against posterior.json and against the table.
constexpr char kReadPosterior[] = R"py(
import csv, json, sys
import numpy as np
sys.path.insert(0, sys.argv[3])
import inference
folder, out = sys.argv[1:3]
stored = json.load(open(folder + "/posterior.json"))
opened = inference.inference_data(folder, out + "/draws.csv", folder + "/prediction")
assert list(opened) == ["posterior", "prior", "constant_data", "observed_data", "predictions"]
posterior = opened["posterior"]
assert posterior.log_factor.dims == ("chain", "draw", "parameter"), posterior.log_factor.dims
assert posterior.log_factor.shape == (4, 1000, 4)
assert list(posterior.parameter.values) == stored["names"], posterior.parameter.values
assert posterior.shear.attrs["units"] == "N/m" and posterior.bend_weft.attrs["units"] == "N m"
for group in opened.values():
    for name in group.data_vars:
        assert "units" in group[name].attrs, name
        for dim in group[name].dims:
            assert dim in group.coords, dim
flat = posterior.log_factor.values.reshape(-1, 4)
sd = np.sqrt(np.diag(stored["covariance"]))
assert np.all(abs(flat.mean(0) - stored["mean"]) < 4 * sd / 4000**0.5), flat.mean(0)
assert np.all(abs(np.cov(flat.T) / stored["covariance"] - 1) < 0.25), np.cov(flat.T)
prior = opened["prior"].log_factor.values.reshape(-1, 4)
assert np.all(abs(prior.std(0) / stored["prior_sd"] - 1) < 0.05), prior.std(0)
constant = opened["constant_data"]
assert np.array_equal(constant.posterior_covariance.values, stored["covariance"])
assert np.array_equal(constant.posterior_mean.values, stored["mean"])
assert list(opened["observed_data"].image.values) == ["front"]
assert opened["observed_data"].drape_coefficient.values[0] == 0.41
assert opened["predictions"].nodes.values.tolist() == [[7.0, 6.0]]
rows = list(csv.DictReader(open(out + "/draws.csv")))
assert len(rows) == 4000 and rows[1000][".chain"] == "2" and rows[1000][".iteration"] == "1"
for i in (0, 1234, 3999):
    assert float(rows[i]["log_factor[bend]"]) == flat[i][1]
    assert float(rows[i]["bend_weft"]) == posterior.bend_weft.values.reshape(-1)[i]
    assert int(rows[i][".draw"]) == i + 1
print("EQUAL")
)py";

TEST_F(StatisticsTest, StatisticiansOpenThePosterior) {
  const std::string python = PythonWith("xarray");
  if (python.empty()) GTEST_SKIP() << "needs python3-xarray";
  WritePosterior(Path(""), Scales(), "test");
  Write("summary.json", R"({"posterior": {}, "images": [
      {"name": "front", "metrics": {"dc_image": 0.41, "folds_image": 6}}]})");
  std::filesystem::create_directories(Path("prediction"));
  Write("prediction/summary.json",
        R"({"drapes": [{"dc": 0.4, "folds": 7}, {"status": "lost"}, {"dc": 0.5, "folds": 6}]})");
  const std::vector<std::string> command = {
      "--fabric=" + Path(""), "--to=csv",         "--draws=4000",        "--chains=4",
      "--starts=0",           "--linear_at=rest", "--out=" + Path("out")};
  const ProcessResult result = Export(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Write("read.py", kReadPosterior);
  const ProcessResult read = RunProcess({"/bin/sh", "-c",
                                         python + " '" + Path("read.py") + "' '" + Path("") +
                                             "' '" + Path("out") + "' '" + kPackage + "'"});
  EXPECT_EQ(read.out, "EQUAL\n") << read.err;
}

// Samples of Scales() of two images, as a fit leaves them, and outlines that depend on their bend.
StoredSamples SamplesOfScales(int count) {
  constexpr int kAngles = 12;
  const StoredPosterior posterior = Scales();
  const int n = posterior.size();
  StoredSamples stored;
  stored.drawn = count + 3;
  for (const char* name : {"front", "back"})
    stored.images.push_back(
        {name, 1e-3 * (1.0 + stored.images.size()), Eigen::VectorXd::Constant(kAngles, 0.12)});
  const Eigen::MatrixXd standard = IndependentSamples(n, count, 5);
  const Eigen::LLT<Eigen::MatrixXd> root(posterior.covariance);
  for (int s = 0; s < count; ++s) {
    const Eigen::VectorXd u = posterior.mean + root.matrixL() * standard.col(s);
    Eigen::MatrixXd radius(kAngles, 2);
    for (int k = 0; k < kAngles; ++k)
      for (int i = 0; i < 2; ++i) radius(k, i) = 0.12 + 2e-3 * u[1] * std::cos(k + i) + 1e-4 * k;
    stored.samples.push_back({u, -0.5 * u.cwiseQuotient(posterior.prior_sd).squaredNorm(),
                              -0.5 * standard.col(s).squaredNorm(), radius});
  }
  return stored;
}

// The rules of InferenceData, and the log-likelihood by its formula.
constexpr char kReadLikelihood[] = R"py(
import csv, json, sys
import numpy as np
sys.path.insert(0, sys.argv[3])
import inference
folder, out = sys.argv[1:3]
stored = json.load(open(folder + "/samples.json"))
groups = inference.inference_data(folder, out + "/draws.csv")
assert set(groups) == {"posterior", "prior", "posterior_predictive", "log_likelihood",
                       "sample_stats", "observed_data", "constant_data"}
for name, group in groups.items():
    sampled = name not in ("observed_data", "constant_data")
    assert group.attrs["inference_library"] == "drapefit"
    for variable in group.data_vars:
        assert "units" in group[variable].attrs, (name, variable)
        dims = group[variable].dims
        assert all(dim in group.coords for dim in dims), (name, variable)
        assert (dims[:2] == ("chain", "draw")) == sampled, (name, variable, dims)
posterior = groups["posterior"]
for name in ("posterior_predictive", "log_likelihood", "sample_stats"):
    for dim in ("chain", "draw"):
        assert np.array_equal(groups[name][dim], posterior[dim]), (name, dim)
assert posterior.sizes["chain"] == 4 and posterior.sizes["draw"] == 50, posterior.sizes
observed, likelihood = groups["observed_data"].outline, groups["log_likelihood"].outline
sigma = groups["constant_data"].sigma
assert observed.dims == ("image", "angle") and list(observed.image.values) == ["front", "back"]
assert likelihood.dims[2:] == observed.dims and observed.attrs["units"] == "m"
assert observed.angle.attrs["units"] == "degree" and observed.angle.values[1] == 30.0
assert np.array_equal(observed.values, [i["radius_m"] for i in stored["images"]])
assert list(sigma.values) == [i["sigma_m"] for i in stored["images"]]
drawn = posterior.drape_outline.values.reshape(200, 2, 12)
assert np.array_equal(drawn, [s["radius_m"] for s in stored["samples"][:200]])
factors = posterior.log_factor.values.reshape(200, 4)
assert np.array_equal(factors, [s["log_factors"] for s in stored["samples"][:200]])
again = (-0.5 * ((posterior.drape_outline - observed) / sigma) ** 2
         - np.log(sigma * np.sqrt(2 * np.pi)))
assert np.allclose(again.transpose(*likelihood.dims).values, likelihood.values, rtol=0, atol=1e-11)
stats = groups["sample_stats"]
prior = np.reshape([s["log_prior"] for s in stored["samples"][:200]], (4, 50))
assert np.allclose(stats.lp.values, likelihood.sum(("image", "angle")).values + prior, atol=1e-9)
seen = (groups["posterior_predictive"].outline - posterior.drape_outline) / sigma
assert abs(float(seen.mean())) < 5 / seen.size ** 0.5 and abs(float(seen.std()) - 1) < 0.05
rows = list(csv.DictReader(open(out + "/draws.csv")))
flat = likelihood.values.reshape(200, 24)
for i in (0, 77, 199):
    assert [float(rows[i]["log_lik[%d]" % (k + 1)]) for k in range(24)] == list(flat[i])
    assert float(rows[i]["lp__"]) == stats.lp.values.reshape(-1)[i]
print("EQUAL")
)py";

TEST_F(StatisticsTest, LogLikelihoodIsThatOfTheOutlines) {
  const std::string python = PythonWith("xarray");
  if (python.empty()) GTEST_SKIP() << "needs python3-xarray";
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), SamplesOfScales(203));
  const ProcessResult result = Export({"--fabric=" + Path(""), "--to=csv", "--chains=4",
                                       "--starts=0", "--linear_at=rest", "--out=" + Path("out")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  Write("read.py", kReadLikelihood);
  const ProcessResult read = RunProcess({"/bin/sh", "-c",
                                         python + " '" + Path("read.py") + "' '" + Path("") +
                                             "' '" + Path("out") + "' '" + kPackage + "'"});
  EXPECT_EQ(read.out, "EQUAL\n") << read.err;
}

// As an R user takes the table to leave-one-out cross-validation.
TEST_F(StatisticsTest, RsLooHasOurParetoShapes) {
  if (RunProcess({"/bin/sh", "-c", "Rscript -e 'library(loo)'"}).exit_code != 0)
    GTEST_SKIP() << "needs Rscript and R's loo (r-cran-loo)";
  const StoredSamples samples = SamplesOfScales(400);
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), samples);
  ASSERT_EQ(Export({"--fabric=" + Path(""), "--to=csv", "--starts=0", "--linear_at=rest",
                    "--out=" + Path("out")})
                .exit_code,
            0);
  Write("loo.R", R"r(
suppressPackageStartupMessages(library(loo))
draws <- read.csv(commandArgs(TRUE)[1], check.names = FALSE)
ll <- as.matrix(draws[, grep("^log_lik", names(draws))])
shape <- function(weights)
  suppressWarnings(psis(weights, r_eff = 1))$diagnostics$pareto_k
shapes <- apply(-ll, 2, shape)
approximate <- suppressWarnings(
  loo_approximate_posterior(ll, log_p = draws[["lp__"]], log_g = draws[["lp_approx__"]]))
cat(sprintf("%.12g\n", c(shape(draws[["lp__"]] - draws[["lp_approx__"]]), shapes,
                         approximate$estimates["elpd_loo", "Estimate"])))
)r");
  const ProcessResult r = RunProcess(
      {"/bin/sh", "-c", "Rscript '" + Path("loo.R") + "' '" + Path("out/draws.csv") + "'"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  std::istringstream numbers(r.out);
  const auto next = [&] {
    double number = std::nan("");
    numbers >> number;
    return number;
  };
  Eigen::MatrixXd likelihood(24, 400);
  Eigen::VectorXd weights(400);
  for (int s = 0; s < 400; ++s) {
    const StoredSamples::Sample& sample = samples.samples[s];
    likelihood.col(s) = samples.LogLikelihood(sample).reshaped();
    weights[s] = likelihood.col(s).sum() + sample.log_prior - sample.log_density;
  }
  EXPECT_NEAR(next(), ParetoShape(weights), 1e-9);
  for (int k = 0; k < 24; ++k)
    EXPECT_NEAR(next(), ParetoShape(-likelihood.row(k).transpose()), 1e-9) << "radius " << k;
  EXPECT_TRUE(std::isfinite(next())) << r.out;
}

TEST_F(StatisticsTest, SamplesBelongToTheirFit) {
  const std::string out = "--out=" + Path("out");
  WritePosterior(Path(""), Scales(), "test");
  WriteSamples(Path(""), SamplesOfScales(3));
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", "--chains=4", out}),
                     "has 3 samples");
  Write("summary.json", R"({"posterior": {}, "images": [
      {"name": "other", "metrics": {"dc_image": 0.41, "folds_image": 6}}]})");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}),
                     "has other images than summary.json");
  Write("samples.json", "{\"format\": \"drapefit-samples\"}");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}),
                     "samples.json: key 'version'");
  EXPECT_EQ(Export({"--fabric=" + Path(""), "--to=csv", "--draws=10", "--starts=0",
                    "--linear_at=rest", out})
                .exit_code,
            0);
}

TEST_F(StatisticsTest, APosteriorIsNeededForItsFiles) {
  const std::string out = "--out=" + Path("out");
  ExpectOneLineError(Export({"--fabric=" + kFabric, "--to=csv", out}), "has no posterior");
  WritePosterior(Path(""), Scales(), "test");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", "--draws=7", "--chains=2", out}),
                     "multiple");
  StoredPosterior elements;
  elements.kind = PosteriorKind::kElements;
  elements.base = ReadMaterial(kFabric).field;
  elements.mean = Eigen::VectorXd::Zero(39);
  elements.prior_sd = elements.element_sd = Eigen::VectorXd::Ones(39);
  WritePosterior(Path(""), elements, "test");
  ExpectOneLineError(Export({"--fabric=" + Path(""), "--to=csv", out}), "kind bdp");
}

}  // namespace
}  // namespace drape::test
