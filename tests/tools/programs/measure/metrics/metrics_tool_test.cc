// SPDX-License-Identifier: Apache-2.0
// drape_metrics as a user runs it.
#include <cmath>
#include <fstream>

#include "tests/losses/image/photograph.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kMetrics = std::string(DRAPE_BIN_DIR) + "/drape_metrics";
constexpr double kPixel = 1 / 719.5;  // [m]

class MetricsTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {kMetrics};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return RunProcess(command);
  }

  // A fan around the origin, wider on one side.
  std::string AddMesh(const std::string& name, double turn, double height) const {
    std::string v = "v 0 0 0\n", f;
    for (int k = 0; k < 120; ++k) {
      const double angle = 2 * M_PI * k / 120;
      const double r = 0.1 + 0.006 * std::cos(3 * angle) + 0.003 * std::sin(angle);
      v += "v " + std::to_string(r * std::cos(angle + turn)) + " " +
           std::to_string(r * std::sin(angle + turn)) + " " + std::to_string(height) + "\n";
      f += "f 1 " + std::to_string(2 + k) + " " + std::to_string(2 + (k + 1) % 120) + "\n";
    }
    return Write(name, v + f);
  }
};

TEST_F(MetricsTool, HelpNamesTheOperands) {
  EXPECT_THAT(Run({"--help"}).out, HasSubstr("usage: drape_metrics [A [B …]] [--config=FILE]"));
}

TEST_F(MetricsTool, TwoImages) {
  const std::string a = AddDisc("a.png", 0.10), b = AddDisc("b.png", 0.12);
  const ProcessResult result = Run({a, b, "--out=" + Path("m.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("outline Hausdorff [mm]"));
  const Json json = ReadJson(Path("m.json"));
  EXPECT_NEAR(json["raw"]["outline_hausdorff_m"], 0.02, 0.3 * kPixel);
  EXPECT_NEAR(json["raw"]["iou"], 0.01 / 0.0144, 0.01);
  EXPECT_NEAR(json["raw"]["mse"], M_PI * 0.0044 / (256 * 256 * kPixel * kPixel), 4e-3);
  EXPECT_EQ(json["a"]["shape"]["folds"], 0);
  EXPECT_EQ(json["camera"]["px_per_m"], 719.5);
  EXPECT_FALSE(json["raw"].contains("surface_hausdorff_m"));
}

TEST_F(MetricsTool, SamplesHaveMeansAndDifferences) {
  for (const auto& [name, radius] : {std::pair("a", 0.10), {"b", 0.12}, {"c", 0.12}, {"d", 0.13}})
    AddDisc(std::string(name) + ".png", radius);
  const std::string table = Write("samples.csv",
                                  "file,fabric,specimen,diameter\na.png,soft,1,0.3\n"
                                  "b.png,soft,2,0.3\nc.png,stiff,1,0.3\nd.png,stiff,2,0.3\n");
  const ProcessResult result = Run({table, "--out=" + Path("m.json"), "--csv=" + Path("m.csv"),
                                    "--statistics=" + Path("s.csv")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("the drape coefficient of stiff is not distinguished"));
  const Json groups = ReadJson(Path("m.json"))["samples"]["groups"];
  // (r² − .09²)/(.15² − .09²) of 10 and 12 cm: 13.2 and 43.8 %.
  EXPECT_NEAR(groups[0]["dc_percent"], 28.5, 0.3);
  EXPECT_NEAR(groups[0]["dc_sd_percent"], 21.6, 0.3);
  EXPECT_THAT(Read(Path("m.csv")), HasSubstr("file,fabric,specimen,diameter,dc,"));
  EXPECT_THAT(Read(Path("s.csv")), HasSubstr("\nstiff,,,,2,"));
  Write("samples.csv", "file,diameter\na.png,0.3\nb.png,30 cm\n");
  ExpectOneLineError(Run({table}), "samples.csv:3: column 'diameter': found '30 cm'");
}

TEST_F(MetricsTool, DrapesOfDifferentSizesAreNotCompared) {
  const std::string a = AddDisc("a.png", 0.10), small = Path("small.png");
  WritePng(ObserveDisc(0.10, Camera(), {0.12, 0.09}).image, small, DrapeDiscs{0.12, 0.09});
  WritePng(ReadImage(a), Path("b.png"), DrapeDiscs());
  ExpectOneLineError(Run({Path("b.png"), small}), "drapes of different sizes cannot be compared");
  ExpectOneLineError(Run({small, "--specimen=0.3"}), "is of a specimen of 24 cm on 18 cm");
  ExpectOneLineError(Run({"--data=" + AddData(), "--specimen=0.24"}), "published data set");
  // By itself each has its own: (.1² − .09²)/(.12² − .09²), and a sheet of it.
  ASSERT_EQ(Run({small, "--out=" + Path("m.json"), "--csv=" + Path("m.csv")}).exit_code, 0);
  const Json json = ReadJson(Path("m.json"));
  EXPECT_NEAR(json["shape"]["dc"], 0.0019 / 0.0063, 3e-3);
  EXPECT_EQ(json["laboratory"]["rows"][0]["value"], 24.0);
  EXPECT_THAT(Read(Path("m.csv")), HasSubstr(",specimen_cm,support_cm,dc_percent,nodes,"));
  EXPECT_THAT(Run({a, "--specimen=0.24"}).out, HasSubstr("drape distance ratio"));
}

// A photograph of 1200 × 900 px, off centre, under uneven light, with a label.
TEST_F(MetricsTool, APhotographByItself) {
  const Camera camera = PhotographCamera();
  GrayImage star = StarSilhouette(camera);
  FillRectangle(&star, 1100, 50, 60, 40, 0.9f);
  WritePng(Photograph(star, {.cloth = 0.12, .background = 0.48}), Path("photo.png"));
  ExpectOneLineError(Run({Path("photo.png")}), "is a photograph without a scale: drape_photo");
  const ProcessResult result =
      Run({Path("photo.png"), "--image_width_mm=480", "--out=" + Path("m.json"),
           "--csv=" + Path("m.csv"), "--overlay=" + Path("m.png")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* text : {"1200x900 px, 2500.0 px/m (given), centre (640.",
                           "drape coefficient [%]", "note: photograph"})
    EXPECT_THAT(result.out, HasSubstr(text));
  const Json json = ReadJson(Path("m.json"));
  EXPECT_NEAR(json["shape"]["dc"], 0.444, 0.01);
  EXPECT_EQ(json["shape"]["folds"], 7);
  EXPECT_NEAR(json["camera"]["cx"], camera.cx, 1);
  EXPECT_EQ(json["quality"]["photograph"], true);
  EXPECT_THAT(Read(Path("m.csv")), HasSubstr("file,dc,folds,"));
  EXPECT_EQ(ReadImage(Path("m.png")).width, 1200);
}

// A bad image is a line with the reason; with nothing else, an error.
TEST_F(MetricsTool, AFolderIsATable) {
  AddDisc("many/a.png", 0.10);
  AddDisc("many/b.png", 0.12);
  Write("many/c.png", "no image");
  const ProcessResult result =
      Run({Path("many"), "--csv=" + Path("m.csv"), "--out=" + Path("m.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("not measured: is neither JPEG nor PNG"));
  const std::string csv = Read(Path("m.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(csv, HasSubstr(",is neither JPEG nor PNG (by its first bytes)\n"));
  const Json drapes = ReadJson(Path("m.json"))["drapes"];
  ASSERT_EQ(drapes.size(), 3u);
  EXPECT_NEAR(drapes[1]["radius_mean_m"], 0.12, 1e-4);
  EXPECT_THAT(drapes[2]["error"].get<std::string>(), HasSubstr("neither JPEG"));
  EXPECT_EQ(Run({Path("many/a.png"), Path("many/b.png"), Path("many/c.png")}).out, result.out);
  std::filesystem::remove(Path("many/a.png"));
  std::filesystem::remove(Path("many/b.png"));
  ExpectOneLineError(Run({Path("many")}), "none of 1 drapes can be measured");
}

TEST_F(MetricsTool, TwoImagesAboutTheirOwnCentres) {
  Camera moved;
  moved.cx += 8;
  WritePng(StarSilhouette(Camera()), Path("a.png"));
  WritePng(StarSilhouette(moved), Path("b.png"));
  const auto iou = [&](const std::string& centre) {
    const ProcessResult result =
        Run({Path("a.png"), Path("b.png"), "--out=" + Path("m.json"), "--centre=" + centre});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadJson(Path("m.json"))["raw"]["iou"].get<double>();
  };
  EXPECT_LT(iou("auto"), 0.92);
  EXPECT_EQ(iou("auto"), iou("nominal"));
  EXPECT_GT(iou("outline"), 0.99);
  WritePng(StarSilhouette(PhotographCamera()), Path("c.png"));
  ExpectOneLineError(Run({Path("a.png"), Path("c.png")}),
                     "c.png: image is 1200x900 px, expected 256x256");
}

TEST_F(MetricsTool, TwoMeshesAndAnImage) {
  const std::string a = AddMesh("a.obj", 0, -0.05), b = AddMesh("b.obj", 0.6, -0.05);
  ASSERT_EQ(Run({a, b, "--out=" + Path("m.json")}).exit_code, 0);
  const Json json = ReadJson(Path("m.json"));
  EXPECT_NEAR(json["alignment"]["rotation_rad"], -0.6, 0.01);
  EXPECT_EQ(json["alignment"]["mirrored"], false);
  EXPECT_GT(json["raw"]["surface_hausdorff_m"], 5e-3);
  EXPECT_LT(json["aligned"]["surface_hausdorff_m"], 1e-3);
  EXPECT_LT(json["aligned"]["mse"], 0.1 * json["raw"]["mse"].get<double>());
  const ProcessResult mixed = Run({AddDisc("d.png", 0.10), a});
  ASSERT_EQ(mixed.exit_code, 0) << mixed.err;
  EXPECT_THAT(mixed.out, testing::Not(HasSubstr("surface Hausdorff")));
}

// A scan anywhere in the plane is found, in each format; another unit or axis is named.
TEST_F(MetricsTool, MeshesAreCheckedAsPicturesAre) {
  std::ifstream in(AddMesh("a.obj", 0, -0.05));
  std::vector<Eigen::Vector3d> v;
  for (std::string key; in >> key && key == "v";) {
    Eigen::Vector3d& p = v.emplace_back();
    in >> p.x() >> p.y() >> p.z();
  }
  const auto dc = [&](const std::string& file) {
    const ProcessResult result = Run({file, "--out=" + Path("m.json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadJson(Path("m.json"))["shape"]["dc"].get<double>();
  };
  const auto write = [&](const std::string& name, const auto& move) {
    const bool stl = name.ends_with(".stl");
    std::string text = stl ? "solid s\n"
                           : "ply\nformat ascii 1.0\nelement vertex 121\nproperty "
                             "float x\nproperty float y\nproperty float z\nelement "
                             "face 120\nproperty list uchar int vertex_index\n"
                             "end_header\n";
    const auto point = [&](int i) {
      const Eigen::Vector3d p = move(v[i]);
      return std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) +
             "\n";
    };
    for (int i = 0; i < 121 && !stl; ++i) text += point(i);
    for (int k = 0; k < 120; ++k) {
      const int next = 1 + (k + 1) % 120;
      text += stl ? "vertex " + point(0) + "vertex " + point(1 + k) + "vertex " + point(next)
                  : "3 0 " + std::to_string(1 + k) + " " + std::to_string(next) + "\n";
    }
    return Write(name, text);
  };
  const double expected = dc(Path("a.obj"));
  const Eigen::Vector3d far(0.7, -2.0, 1.0);
  EXPECT_NEAR(dc(write("far.stl", [&](const Eigen::Vector3d& p) { return p + far; })), expected,
              2e-3);
  EXPECT_NEAR(dc(write("far.ply", [&](const Eigen::Vector3d& p) { return p + far; })), expected,
              2e-3);
  ExpectOneLineError(Run({Path("far.stl"), "--centre=nominal"}), "far.stl: ");
  const std::string mm = write("mm.stl", [](const Eigen::Vector3d& p) { return 1000 * p; });
  for (const std::vector<std::string>& operands :
       {std::vector{mm}, std::vector{Path("a.obj"), mm}, std::vector{mm, mm, mm}})
    ExpectOneLineError(Run(operands),
                       " m wide, expected 0.17 … 0.32 m of a specimen of 30 cm on 18 cm; in mm it "
                       "would be 0.2");
  ExpectOneLineError(
      Run({write("y.ply",
                 [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), 0, p.y()); })}),
      "expected a drape that hangs along z: is another axis up?");
  ExpectOneLineError(Run({write("small.ply", [](const Eigen::Vector3d& p) { return 0.9 * p; })}),
                     "of the centre, expected at least 86 with a support of 90 mm");
  const std::string deep = write("deep.stl", [](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(1.4 * p.x(), 1.4 * p.y(), 4 * p.z());
  });
  for (const std::vector<std::string>& operands :
       {std::vector{deep}, std::vector{Path("a.obj"), deep}})
    ExpectOneLineError(Run(operands),
                       "cm2, expected at most 804 of a specimen of 30 cm on 18 cm: ");
}

// A ruler of 20 cm along 500 px, and a scan of 2.5 dots in a millimetre.
TEST_F(MetricsTool, TheScaleOfAPicture) {
  const Camera camera = PhotographCamera();
  WritePng(StarSilhouette(camera), Path("a.png"));
  const auto scale = [&](const std::string& option) {
    const ProcessResult result = Run({Path("a.png"), option, "--out=" + Path("m.json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ReadJson(Path("m.json"))["camera"]["px_per_m"].get<double>();
  };
  EXPECT_NEAR(scale("--ruler=100,800,400,400,200"), 2500, 1e-9);
  ExpectOneLineError(Run({Path("a.png"), "--ruler=100,800,400,400"}),
                     "found 4 numbers and points 0 px apart");
  ExpectOneLineError(Run({Path("a.png"), "--ruler=1,8,4,4,200"}),
                     "found 5 numbers and points 5 px apart");
  ExpectOneLineError(Run({Path("a.png"), "--ruler=100,800,400,400,0.2"}),
                     "in m it would be 200 mm");
  ExpectOneLineError(Run({Path("a.png"), "--ruler=100,800,400,400,200", "--camera_scale=2500"}),
                     "found two of camera_scale, image_width_mm, dpi and ruler");
  ExpectOneLineError(Run({Path("a.png"), "--dpi"}), "a.png: states 0 and 0 dots an inch");
  std::string png = Read(Path("a.png"));
  png.insert(33, std::string("\0\0\0\x09pHYs\0\0\x09\xC4\0\0\x09\xC4\x01\0\0\0\0", 21));
  Write("a.png", png);
  EXPECT_EQ(scale("--dpi"), 2500);
  ExpectOneLineError(Run({Path("a.png"), "--camera_scale=25"}), "in px/cm it would be 2500");
  ExpectOneLineError(Run({Path("a.png"), "--image_width_mm=48"}), "in cm it would be 480");
  ExpectOneLineError(Run({AddMesh("a.obj", 0, 0), "--dpi"}), "found without a picture");
}

TEST_F(MetricsTool, DrapesOfDrapeSimulate) {
  ASSERT_EQ(Simulate({"--out=" + Path("one")}).exit_code, 0);
  ASSERT_EQ(Simulate({"--out=" + Path("two"), "--steps=5"}).exit_code, 0);
  ASSERT_EQ(
      Run({Path("one/drape.obj"), Path("two/drape.obj"), "--out=" + Path("m.json")}).exit_code, 0);
  const Json pair = ReadJson(Path("m.json"));
  EXPECT_GT(pair["raw"]["surface_hausdorff_m"], 1e-3);
  const double dc = ReadJson(Path("one/summary.json"))["dc"];
  EXPECT_NEAR(pair["a"]["shape"]["dc"], dc, 5e-3);
}

TEST_F(MetricsTool, FoldersAreDrawsAndWhatWasObserved) {
  for (const double radius : {0.10, 0.103, 0.106})
    AddDisc("draws/" + std::to_string(radius) + ".png", radius);
  AddDisc("seen/a.png", 0.103);
  const ProcessResult result = Run({Path("draws"), Path("seen"), "--out=" + Path("m.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("3 draws in"));
  const Json json = ReadJson(Path("m.json"));
  EXPECT_EQ(json["observed"], 1);
  EXPECT_EQ(json["draws"], 3);
  EXPECT_EQ(json["features"]["dc"]["interval_90"]["coverage"], 1);
  EXPECT_EQ(json["features"]["dc"]["interval_90"]["nominal"], 0.5);
  ExpectOneLineError(Run({Path("seen"), Path("draws")}), "found 1 images and meshes, expected at");
}

TEST_F(MetricsTool, DataSetSplitAndTrivialPredictors) {
  const std::string data = "--data=" + AddData();
  const ProcessResult result =
      Run({data, "--data_fabric=3", "--train=2", "--split_seed=4", "--face=up",
           "--save_split=" + Path("s.json"), "--out=" + Path("m.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("8 captures, 0 training images"));
  EXPECT_THAT(result.out, HasSubstr("skipped: "));
  EXPECT_THAT(result.out, HasSubstr("neither JPEG nor PNG"));
  EXPECT_THAT(result.out, HasSubstr("circle of the mean area"));
  const Json json = ReadJson(Path("m.json"));
  EXPECT_EQ(json["split"]["train"].size(), 4u);
  EXPECT_EQ(json["split"]["held_out"].size(), 4u);
  const Json& rows = json["trivial_predictors"]["rows"];
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0]["name"], "same sample, same face");
  EXPECT_EQ(rows[0]["mean"]["mse"], 0);
  EXPECT_GT(rows[1]["mean"]["mse"], 0.01);
  // The stored split gives the same figures.
  ASSERT_EQ(Run({data, "--split=" + Path("s.json"), "--out=" + Path("n.json")}).exit_code, 0);
  EXPECT_EQ(ReadJson(Path("n.json"))["trivial_predictors"], json["trivial_predictors"]);
  EXPECT_EQ(ReadJson(Path("n.json"))["split"], json["split"]);
}

TEST_F(MetricsTool, EachSampleInTurn) {
  const std::string data = "--data=" + AddData();
  const ProcessResult result =
      Run({data, "--samples=1-4", "--train=0", "--noaligned", "--out=" + Path("m.json")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("each sample is held out in turn"));
  const Json json = ReadJson(Path("m.json"));
  EXPECT_EQ(json["held_out_in_turn"].size(), 16u);
  EXPECT_EQ(json["trivial_predictors"]["other_samples"]["observed"], 16);
  EXPECT_FALSE(json["trivial_predictors"]["rows"][1].contains("aligned_mean"));
}

TEST_F(MetricsTool, MistakesAreOneLineAndWriteNothing) {
  const std::string a = AddDisc("a.png", 0.1), data = "--data=" + AddData();
  const std::string out = "--out=" + Path("m.json");
  ExpectOneLineError(Run({out}), "found no file or folder, expected a drape");
  ExpectOneLineError(Run({a, a, Path("set"), out}), "is a folder among files");
  ExpectOneLineError(Run({a, a, "--csv=" + Path("m.csv"), out}), "option 'csv'");
  ExpectOneLineError(Run({Path("set"), "--overlay=" + Path("m.png"), out}), "option 'overlay'");
  ExpectOneLineError(Run({a, Path("none.png"), out}), "none.png: no such file or folder");
  ExpectOneLineError(Run({a, Path("set"), out}), "set: is a folder, expected a file like");
  ExpectOneLineError(Run({a, Write("b.png", "text"), out}), "neither JPEG nor PNG");
  ExpectOneLineError(Run({a, Write("c.obj", "v 0 0"), out}), "c.obj:1");
  ExpectOneLineError(Run({a, a, "--camera_width=128", out}),
                     "image is 256x256 px, expected 128x256");
  ExpectOneLineError(Run({a, data, out}), "beside --data");
  ExpectOneLineError(Run({data, "--data_fabric=x", out}), "option 'data_fabric': found 'x'");
  ExpectOneLineError(Run({data, "--data_fabric=9", out}), "fabric: found 9, expected some of 3");
  ExpectOneLineError(Run({data, "--train=4", "--samples=1-4", out}), "fewer than the 4");
  ExpectOneLineError(Run({data, "--face=left", out}), "expected one of up, down, both");
  ExpectOneLineError(Run({data, "--split=" + Path("no.json"), out}), "no.json");
  ExpectOneLineError(Run({data, "--split=" + Path("no.json"), "--data_fabric=3", out}),
                     "beside it");
  ExpectOneLineError(Run({data, "--train=0", "--save_split=" + Path("s.json"), out}),
                     "no split to store");
  ExpectOneLineError(Run({"--data=" + Path("nothing"), out}), "is not a folder");
  EXPECT_FALSE(std::filesystem::exists(Path("m.json")));
  EXPECT_FALSE(std::filesystem::exists(Path("s.json")));
}

}  // namespace
}  // namespace drape::test
