// SPDX-License-Identifier: Apache-2.0
// drape_fit from a silhouette to files, interrupted and resumed.
#include <span>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/outline/outline.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/mesh/obj_io.h"
#include "solver/fit_drapes.h"
#include "tests/tools/tool_fixture.h"
#include "tools/inputs/fit_options.h"

namespace drape::test {
namespace {

class FitTool : public ToolFixture {
 protected:
  // The silhouette of a drape of the start material, so a fit converges near its initial guess.
  void SetUp() override {
    ASSERT_EQ(Simulate({"--mesh=disc:150", "--steps=60", "--time_step=0.1",
                        "--out=" + Path("ground_truth")})
                  .exit_code,
              0);
    std::filesystem::copy(Path("ground_truth/silhouette.png"), Path("drape.png"));
  }

  std::vector<std::string> FitCommand(const std::string& out,
                                      const std::string& more = "--noresume") const {
    return {kFit,
            "--images=" + Path("drape.png"),
            "--fabric=" + kFabric,
            "--mesh=disc:150",
            "--coarse_mesh=disc:100",
            "--initial_stretch=1",
            "--initial_bend=0.5,1",
            "--initial_lifts=0.5,1",
            "--candidates_per_round=3,2,1",
            "--iterations=4,4,6",
            "--num_parameters=2",
            "--centre=nominal",
            "--threads=1",
            "--out=" + out,
            more};
  }
};

TEST_F(FitTool, WritesItsResult) {
  const ProcessResult result = RunProcess(FitCommand(Path("fit")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  if (kSlowdown == 1.0) {  // slower, it prints its progress
    EXPECT_EQ(result.err, "");
  }
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(summary.at("model"), "homogeneous");
  EXPECT_EQ(summary.at("status"), "done");
  EXPECT_EQ(summary.at("provenance").at("build").at("drapefit"), DRAPE_VERSION);
  const Json& metrics = summary.at("images").at(0).at("metrics");
  for (const char* key :
       {"mse", "iou", "profile_rms_px", "dc_image", "dc_fit", "folds_image", "folds_fit"})
    EXPECT_TRUE(metrics.contains(key)) << key;
  EXPECT_GT(metrics.at("iou"), 0.8);
  EXPECT_EQ(summary.at("images").at(0).at("stability").at("stable"), true);
  EXPECT_EQ(ReadMaterial(Path("fit/material.json")).source_convention, "mechanical");
  EXPECT_EQ(ReadObjSurface(Path("fit/drape_drape.obj")).x.size(), 450);
  EXPECT_EQ(ReadImage(Path("fit/fit_drape.png")).width, 768);
  EXPECT_FALSE(std::filesystem::exists(Path("fit/checkpoint.json")));
}

// An image has the fit with --each that it has alone, beside others of which one cannot be fitted;
// a second run fits again what has changed.
TEST_F(FitTool, FitsEachImageByItself) {
  std::filesystem::create_directories(Path("images"));
  for (const char* name : {"a", "b"})
    std::filesystem::copy(Path("drape.png"), Path("images/" + std::string(name) + ".png"));
  Write("images/c.png", "no image");
  std::vector<std::string> command = FitCommand(Path("each"));
  command[1] = "--images=" + Path("images");
  command.back() = "--each";
  command.push_back("--threads=2");
  const ProcessResult result = RunProcess(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("no result: c: "));
  ASSERT_EQ(RunProcess(FitCommand(Path("fit"))).exit_code, 0);
  const std::string material = Read(Path("fit/material.json"));
  EXPECT_EQ(Read(Path("each/a/material.json")), material);
  EXPECT_EQ(Read(Path("each/b/material.json")), material);
  const Json fits = ReadJson(Path("each/each.json")).at("fits");
  ASSERT_EQ(fits.size(), 3);
  EXPECT_EQ(fits.at(0).at("image"), "a");
  EXPECT_EQ(fits.at(0).at("grade"), ReadJson(Path("fit/summary.json")).at("verdict").at("grade"));
  EXPECT_THAT(fits.at(2).at("failure").get<std::string>(), testing::HasSubstr("c.png"));
  const std::string csv = Read(Path("each/each.csv"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 4);
  EXPECT_THAT(
      csv, testing::HasSubstr("image,grade,error_px,dc_percent,nodes,bending_length_overall_cm,"));

  const auto written = [&](const std::string& name) {
    return std::filesystem::last_write_time(Path("each/" + name + "/summary.json"));
  };
  const auto of_a = written("a"), of_b = written("b");
  ASSERT_EQ(Simulate({"--mesh=disc:150", "--steps=40", "--time_step=0.1", "--out=" + Path("b")})
                .exit_code,
            0);
  std::filesystem::rename(Path("b/silhouette.png"), Path("images/b.png"));
  EXPECT_EQ(RunProcess(command).exit_code, 0);
  EXPECT_EQ(written("a"), of_a);
  EXPECT_NE(written("b"), of_b);
  EXPECT_NE(Read(Path("each/b/material.json")), material);

  command.push_back("--lab_tests=" + Path("drape.png"));
  ExpectOneLineError(RunProcess(command), "option 'lab_tests'");
}

// The fitted drape is a drape of the fitted material from the stored start: its replay is the fit.
TEST_F(FitTool, AReplayFindsTheFittedDrape) {
  ASSERT_EQ(RunProcess(FitCommand(Path("fit"))).exit_code, 0);
  ASSERT_EQ(Simulate({"--mesh=disc:150", "--fabric=" + Path("fit/material.json"),
                      "--start=" + Path("fit/start_drape.json"), "--solve=static"})
                .exit_code,
            0);
  const Eigen::VectorXd fit = ReadState(Path("fit/start_drape.json"), 150).x;
  EXPECT_LT((ReadObjSurface(Path("out/drape.obj")).x - fit).cwiseAbs().maxCoeff(), 1e-7);
  // In the image it may be turned and mirrored.
  const Json image = ReadJson(Path("fit/summary.json")).at("images").at(0);
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(ReadImage(Path("drape.png")), Camera(), 360, &outline));
  const Mesh mesh = ReadObj(Path("fit/drape_drape.obj"));
  const Eigen::VectorXd seen =
      TurnedAboutZ(fit, image.at("cloth_turned_degrees").get<double>() * M_PI / 180,
                   image.at("cloth_mirrored").get<bool>());
  EXPECT_LT((ReadObjSurface(Path("fit/drape_drape.obj")).x - seen).cwiseAbs().maxCoeff(), 1e-9);
  Outline fitted;
  ASSERT_TRUE(OutlineFromMesh(mesh, seen, Camera(), 360, &fitted));
  EXPECT_NEAR(ProfileRms(outline.radius, fitted.radius),
              image.at("metrics").at("profile_rms_px").get<double>(), 1e-6);
}

// One option for the photograph and the fit: the picture's file says it where the user does not.
TEST_F(FitTool, KnowsWhereTheWarpIs) {
  ExpectOneLineError(RunProcess(FitCommand(Path("fit"), "--warp=9x")),
                     "option 'warp': found '9x', expected up, right, unknown or whole degrees");
  const ProcessResult unknown = RunProcess(FitCommand(Path("fit")));
  EXPECT_THAT(unknown.out, testing::AllOf(testing::HasSubstr("stiffer"),
                                          testing::Not(testing::HasSubstr("weft"))));
  Json camera = CameraJson(Camera());
  camera["warp"] = "right";
  const std::string file = Write("camera.json", camera.dump());
  const ProcessResult known = RunProcess(FitCommand(Path("fit"), "--camera_file=" + file));
  EXPECT_THAT(known.out, testing::HasSubstr("weft"));
  EXPECT_EQ(ReadJson(Path("fit/summary.json")).at("images").at(0).at("warp_degrees"), 0);
}

// A fit in memory has the bits of the program's files.
TEST_F(FitTool, FitDrapesHasItsBits) {
  const std::vector<std::string> command = FitCommand(Path("fit"), "--model=bayes");
  const ProcessResult result = RunProcess(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  FitToolOptions options;
  const OptionTable table = FitTable(options);
  for (const std::string& flag : std::span(command).subspan(1)) {
    const std::size_t equals = flag.find('=');
    table.Set(flag.substr(2, equals - 2), flag.substr(equals + 1), "test");
  }
  const FitSpec spec = MakeFitSpec(options);
  const DrapeFit fit =
      FitDrapes(spec, {.drapes = {ReadImageObservation(Path("drape.png"), spec.observation)},
                       .start = ReadMaterial(kFabric).field});
  ASSERT_TRUE(fit.fitted());
  const MaterialField written = ReadMaterial(Path("fit/material.json")).field;
  for (int i = 0; i < kStretchEntries; ++i)
    EXPECT_EQ(fit.material.stretch[0].entries()[i], written.stretch[0].entries()[i]);
  for (int i = 0; i < kBendEntries; ++i)
    EXPECT_EQ(fit.material.bend[0].entries()[i], written.bend[0].entries()[i]);
  EXPECT_EQ(fit.drapes.at(0), ReadState(Path("fit/start_drape.json"), 150).x);
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(ToString(fit.verdict.grade), summary.at("verdict").at("grade").get<std::string>());
  EXPECT_EQ(fit.notes, summary.at("notes").get<std::vector<std::string>>());
  const Json& rows = summary.at("laboratory").at("material").at("rows");
  ASSERT_EQ(fit.sheet.rows.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_EQ(fit.sheet.rows[i].source, rows[i].at("source").get<std::string>());
  EXPECT_EQ(SamplePosterior(fit, 1, 1).pareto_k, summary.at("posterior").at("pareto_k"));
}

// The size of a specimen is in its silhouette: the mesh, the drape coefficient and the files
// follow.
TEST_F(FitTool, KnowsTheSizeOfTheSpecimen) {
  ASSERT_EQ(Simulate({"--mesh=disc:150", "--steps=60", "--time_step=0.1", "--specimen=0.36",
                      "--out=" + Path("large")})
                .exit_code,
            0);
  const std::string usual = Read(Path("drape.png"));
  std::filesystem::copy(Path("large/silhouette.png"), Path("drape.png"),
                        std::filesystem::copy_options::overwrite_existing);
  const ProcessResult result = RunProcess(FitCommand(Path("fit")));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("Material, as laboratories report it"));
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(summary.at("specimen_diameter_m"), 0.36);
  EXPECT_EQ(summary.at("support_diameter_m"), 0.18);
  const double dc = ReadJson(Path("large/summary.json")).at("dc");
  EXPECT_NEAR(summary.at("images").at(0).at("metrics").at("dc_image").get<double>(), dc, 0.02);
  EXPECT_GT(summary.at("images").at(0).at("metrics").at("iou"), 0.8);
  EXPECT_EQ(ReadObjDiscs(Path("fit/drape_drape.obj")), (DrapeDiscs{0.18, 0.09}));
  const Json& drape = summary.at("laboratory").at("drape_drape").at("rows");
  EXPECT_EQ(drape.at(0).at("value"), 36.0);
  EXPECT_EQ(drape.at(2).at("name"), "drape coefficient DC");
  EXPECT_NEAR(drape.at(2).at("value").get<double>(), 100 * dc, 2.0);
  EXPECT_EQ(summary.at("laboratory").at("material").at("rows").at(0).at("unit"), "g/m²");
  // Another size, two sizes and the published data set are refused, and so is another mesh.
  ExpectOneLineError(RunProcess(FitCommand(Path("fit"), "--specimen=0.3")),
                     "is of a specimen of 36 cm on 18 cm, expected 30 cm on 18 cm");
  Write("usual.png", usual);
  ExpectOneLineError(RunProcess(FitCommand(
                         Path("fit"), "--images=" + Path("drape.png") + "," + Path("usual.png"))),
                     "drapes of different sizes cannot be compared");
  ExpectOneLineError(RunProcess(FitCommand(Path("fit"), "--mesh=disc:150,radius=0.15")),
                     "found a cloth of radius 0.15 m, expected 0.18 m");
}

// The chain by hand, drape_photo and then drape_fit, loses nothing of what a photograph says.
TEST_F(FitTool, PassesOnWhatThePhotographSays) {
  Json camera = CameraJson(Camera());
  camera["photograph"] = PhotographJson({0.4, 0.006, {"glare near the hem"}});
  const std::string file = Write("camera.json", camera.dump());
  const ProcessResult result = RunProcess(FitCommand(Path("fit"), "--camera_file=" + file));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(summary.at("notes").at(0), "drape: glare near the hem");
  EXPECT_EQ(summary.at("images").at(0).at("photograph"), camera["photograph"]);
}

TEST_F(FitTool, FitsCapturesOfTheDataSet) {
  std::vector<std::string> command = FitCommand(Path("fit"));
  command[1] = "--data=" + AddData();
  for (const std::string more : {"--data_fabric=3", "--samples=1,2", "--captures=3"})
    command.push_back(more);
  const ProcessResult result = RunProcess(command);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json summary = ReadJson(Path("fit/summary.json"));
  EXPECT_EQ(summary.at("data_source"), "silhouettes");
  EXPECT_EQ(summary.at("density"), 0.213);
  EXPECT_EQ(summary.at("images").at(1).at("name"), "sample_2_capture_3_down");
  EXPECT_TRUE(std::filesystem::exists(Path("fit/fit_sample_1_capture_3_down.png")));
}

TEST_F(FitTool, MistakesOfTheDataAreOneLine) {
  std::vector<std::string> command = FitCommand(Path("fit"));
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = command;
    all.insert(all.end(), more.begin(), more.end());
    return RunProcess(all);
  };
  ExpectOneLineError(with({"--data=" + AddData(), "--data_fabric=3"}), "found some beside --data");
  ExpectOneLineError(with({"--samples=1"}), "option 'data': not given");
  ExpectOneLineError(with({"--data_source=meshes"}), "option 'data': not given");
  command[1] = "--data=" + Path("set");
  ExpectOneLineError(with({}), "option 'data_fabric': not given");
  ExpectOneLineError(with({"--data_fabric=3", "--data_source=meshes"}), "no usable capture to fit");
  ExpectOneLineError(with({"--data_fabric=4"}), "fabric: found 4, expected some of 3");
  EXPECT_FALSE(std::filesystem::exists(Path("fit")));
}

TEST_F(FitTool, CtrlCLeavesAResultAndResumeTheSameAnswer) {
  ASSERT_EQ(RunProcess(FitCommand(Path("whole"))).exit_code, 0);
  const ProcessResult stopped =
      RunProcess(FitCommand(Path("parts")),
                 {.interrupt_when = Path("parts/checkpoint.json"), .interrupt_after = 0.05});
  ASSERT_EQ(stopped.exit_code, 130) << stopped.out << stopped.err;
  EXPECT_EQ(ReadJson(Path("parts/summary.json")).at("status"), "cancelled");
  EXPECT_TRUE(std::filesystem::exists(Path("parts/checkpoint.json")));
  const ProcessResult resumed = RunProcess(FitCommand(Path("parts"), "--resume"));
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  for (const char* file : {"material.json", "drape_drape.obj", "start_drape.json", "fit_drape.png"})
    EXPECT_EQ(Read(Path(std::string("parts/") + file)), Read(Path(std::string("whole/") + file)))
        << file;
  EXPECT_EQ(ReadJson(Path("parts/summary.json")).at("status"), "done");
}

}  // namespace
}  // namespace drape::test
