// SPDX-License-Identifier: Apache-2.0
// drape_predict as a user runs it.
#include "losses/image/image.h"
#include "losses/image/segmentation.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "solver/posterior/posterior_io.h"
#include "tests/solver/prediction/generative/fake_pool.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

const std::string kPredict = std::string(DRAPE_BIN_DIR) + "/drape_predict";

class PredictTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {
        kPredict,      "--mesh=disc:120",     "--draws=6", "--steps=60", "--fabric=" + kFabric,
        "--threads=2", "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(PredictTool, DrawsDrapesAndScoresThem) {
  const ProcessResult result =
      Run({"--data=" + AddData(), "--samples=1-4", "--train=2", "--split_seed=4", "--keep_meshes"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("scores on the held-out drapes"));
  EXPECT_THAT(result.out, HasSubstr("circle of the mean area"));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary["outcome"], "done");
  EXPECT_EQ(summary["specimens"], 3);
  ASSERT_EQ(summary["drapes"].size(), 6u);
  double dc = 0;
  int at_rest = 0, failed = 0;
  for (size_t i = 0; i < 6; ++i) {
    const Json& drape = summary["drapes"][i];
    const bool stands = drape["status"] == "stable";
    EXPECT_EQ(std::filesystem::exists(Path("out/draw_" + std::to_string(i + 1) + ".obj")), stands);
    if (stands) dc += drape["dc"].get<double>();
    at_rest += stands;
  }
  for (const auto& [status, count] : summary["failures"].items()) failed += count.get<int>();
  EXPECT_EQ(summary["at_rest"], at_rest);
  EXPECT_EQ(at_rest + failed, 6);
  EXPECT_NEAR(summary["features"]["dc"]["mean"], dc / at_rest, 1e-12);
  EXPECT_EQ(summary["score"]["observed"], 8);
  EXPECT_NEAR(summary["score"]["features"]["dc"]["predicted_mean"], dc / at_rest, 0.02);
  EXPECT_EQ(summary["data"]["split"]["seed"], 4);
  EXPECT_EQ(summary["data"]["trivial_predictors"]["circle"]["observed"], 8);
  EXPECT_EQ(ReadImage(Path("out/mean_image.png")).width, 256);
  const Json outlines = ReadJson(Path("out/outlines.json"))["drapes"];
  ASSERT_EQ(outlines.size(), static_cast<size_t>(at_rest));
  for (size_t i = 0, next = 0; i < 6; ++i) {
    const Json& drape = summary["drapes"][i];
    if (drape["status"] != "stable") continue;
    const Json& outline = outlines[next++];
    EXPECT_EQ(outline["group"].get<int>() + 1, drape["specimen"]);
    EXPECT_EQ(outline["dc"], drape["dc"]);
    EXPECT_EQ(outline["folds"], drape["folds"]);
    // The area within the outline is that of the drape coefficient.
    const DrapeDiscs discs;
    const double support = M_PI * discs.support * discs.support,
                 flat = M_PI * discs.specimen * discs.specimen;
    const auto radius = outline["radius_m"].get<std::vector<double>>();
    ASSERT_EQ(radius.size(), 120u);
    const double area =
        std::inner_product(radius.begin(), radius.end(), radius.begin(), 0.0) * M_PI / 120;
    EXPECT_NEAR(area, support + outline["dc"].get<double>() * (flat - support), 0.01 * flat);
  }
}

TEST_F(PredictTool, CalibratesOnTheSideToLearnFrom) {
  const std::vector<std::string> scored = {"--data=" + AddData(), "--samples=1-4",   "--train=2",
                                           "--split_seed=4",      "--mesh=disc:100", "--steps=20"};
  ASSERT_EQ(Run(scored).exit_code, 0);
  const double before = ReadJson(Path("out/summary.json"))["score"]["features"]["dc"]["crps"];
  std::vector<std::string> calibrated = scored;
  calibrated.push_back("--calibrate");
  const ProcessResult result = Run(calibrated);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("calibrated by"));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_LT(summary["score"]["features"]["dc"]["crps"].get<double>(), before);
  const Json& first = summary["calibration"]["trials"][0];
  EXPECT_EQ(first["face"], "up");
  EXPECT_EQ(first["bend_factor"], 1);
  for (const std::string face : {"up", "down"}) {
    const Material material = ReadMaterial(Path("out/material_" + face + ".json"));
    const Material start = ReadMaterial(kFabric);
    const double factor = material.field.bend[0].b[0][0] / start.field.bend[0].b[0][0];
    EXPECT_NEAR(factor, summary["calibration"]["bend_factor_" + face].get<double>(), 1e-12);
  }
}

TEST_F(PredictTool, LearnsSpecimensFromDrapesAndPredictsByThemAgain) {
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = {kPredict,      "--mesh=disc:100", "--draws=6",
                                        "--threads=2", "--steps=30",      "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  };
  const ProcessResult result =
      run({"--learn", "--data=" + AddData(), "--samples=1-4", "--train=2", "--split_seed=4",
           "--pool_drapes=512", "--rounds=1", "--round_drapes=64", "--resamples=2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("bending length"));
  EXPECT_THAT(result.out, HasSubstr("scores on the held-out drapes"));
  const Json summary = ReadJson(Path("out/summary.json"));
  const Json& length = summary["distribution"]["best"]["log_bending_length"];
  EXPECT_LT(length["mean_up"], std::log(0.02));  // discs of DC .1 to .3 are soft cloth
  EXPECT_GT(summary["distribution"]["effective_drapes"], 20);
  EXPECT_EQ(summary["score"]["observed"], 8);
  const Json drapes = summary["drapes"];

  const ProcessResult again = run({"--specimens=" + Path("out/specimens.json")});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(ReadJson(Path("out/summary.json"))["drapes"], drapes);

  ExpectOneLineError(run({"--learn"}), "option 'learn': found true without 'images' or 'data'");
  ExpectOneLineError(run({"--learn", "--fabric=" + kFabric}),
                     "found 2 of them, expected one of them");
  ExpectOneLineError(run({"--specimens=" + Path("out/specimens.json"), "--calibrate"}),
                     "already describe how specimens differ");
  ExpectOneLineError(run({"--specimens=" + Path("out/summary.json")}), "summary.json");
  ExpectOneLineError(run({"--learn", "--data=" + Path("set"), "--samples=1-4", "--train=2",
                          "--pool_seed=2", "--pool=" + Path("out/pool.json")}),
                     "found a pool of seed 1, expected 2");
}

// The silhouette of radii [m] at equal angles.
GrayImage MakeSilhouette(const Eigen::VectorXd& radius) {
  const Camera camera;
  GrayImage image(camera.width, camera.height);
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const double x = column - camera.cx, y = camera.cy - row;
      const double turn = std::atan2(y, x) / (2 * M_PI);
      const auto k = std::lround((turn < 0 ? turn + 1 : turn) * double(radius.size()));
      const double edge = camera.scale * radius[k % radius.size()] - std::hypot(x, y);
      image.at(column, row) = static_cast<float>(std::clamp(edge + 0.5, 0.0, 1.0));
    }
  return image;
}

TEST_F(PredictTool, LearnsFromImagesOfOneSample) {
  const std::string folder = AddData() + "/data/Fabric 3/silhouettes/";
  const std::string up = "--images=" + folder + "Sample_1_Capture_1.png",
                    both = up + "," + folder + "Sample_1_Capture_3.png";
  DrapePool pool = FakePool(1000);
  pool.setting = "smooth law, contact none, 30 steps of 0.1 s";
  WritePool(Path("pool.json"), pool);
  const auto run = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = {kPredict,
                                        "--mesh=disc:100",
                                        "--draws=4",
                                        "--threads=2",
                                        "--steps=30",
                                        "--pool_drapes=1000",
                                        "--pool=" + Path("pool.json"),
                                        "--rounds=0",
                                        "--resamples=9",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command);
  };
  const ProcessResult result =
      run({"--learn", both, "--image_samples=1,1", "--image_faces=up,down"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("bending length, face down [mm]"));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary["learned_from"].size(), 2u);
  for (const std::string face : {"up", "down"}) {
    const Json& specimen = summary["specimen"][face];
    const Json &length = specimen["mean"]["log_bending_length_" + face],
               &interval = specimen["interval_90"]["log_bending_length_" + face];
    EXPECT_LT(length, std::log(0.02));  // a disc of DC .1 is soft cloth
    EXPECT_LT(interval["low"], length);
    EXPECT_GT(interval["high"], length);
    EXPECT_EQ(specimen["like_drapes_of_the_pool"], false);
  }
  EXPECT_THAT(result.out, HasSubstr("no drape of the pool is like it"));  // it is a disc
  // The same silhouette in twice as many pixels, by the camera that the user says.
  const GrayImage small = ReadSilhouette(folder + "Sample_1_Capture_1.png").image;
  GrayImage large(2 * small.width, 2 * small.height);
  for (int row = 0; row < large.height; ++row)
    for (int column = 0; column < large.width; ++column)
      large.at(column, row) = small.at(column / 2, row / 2);
  WritePng(large, Path("large.png"));
  const std::string of_large = "--images=" + Path("large.png");
  ASSERT_EQ(run({"--learn", of_large, "--camera_scale=1439"}).exit_code, 0);
  const Json twice = ReadJson(Path("out/summary.json"));
  EXPECT_NEAR(twice["specimen"]["up"]["mean"]["log_bending_length_up"].get<double>(),
              summary["specimen"]["up"]["mean"]["log_bending_length_up"].get<double>(), 0.02);
  EXPECT_EQ(twice["camera"]["width"], small.width);  // of the predictions
  ExpectOneLineError(run({"--learn", of_large}), "large.png");

  // A cloth that hardly drapes is at the edge of the pool, beyond which it may lie.
  SpecimenNumbers stiff = FakeFabric().mean[0];
  stiff[kLogBendingLength] = NumberRanges()[kLogBendingLength].high;
  WritePng(MakeSilhouette(FakeDrape(stiff, 5).radius), Path("stiff.png"));
  const ProcessResult at_edge = run({"--learn", "--images=" + Path("stiff.png")});
  EXPECT_THAT(at_edge.out, testing::ContainsRegex("bending length, face up \\[mm\\] +at least "));
  const Json bounds = ReadJson(Path("out/summary.json"))["specimen"]["up"]["interval_90"];
  EXPECT_TRUE(bounds["log_bending_length_up"]["high"].is_null()) << bounds;

  // Two samples show how specimens differ.
  ASSERT_EQ(run({"--learn", both}).exit_code, 0);
  const Json of_two = ReadJson(Path("out/summary.json"));
  EXPECT_FALSE(of_two.contains("specimen"));
  const Json& interval = of_two["distribution"]["mean_interval_90"]["log_bending_length_up"];
  EXPECT_LT(interval["low"], interval["high"]);

  ExpectOneLineError(run({"--learn", up, "--data=" + Path("set")}), "found both");
  ExpectOneLineError(run({"--fabric=" + kFabric, up}), "option 'images': found without 'learn'");
  ExpectOneLineError(run({"--fabric=" + kFabric, "--image_faces=up"}), "found without 'images'");
  ExpectOneLineError(run({"--learn", both, "--image_samples=1"}),
                     "option 'image_samples': found 1 values, expected 2, one for each image");
  ExpectOneLineError(run({"--learn", up, "--image_faces=left"}), "expected one of up, down");
  ExpectOneLineError(run({"--learn", up, "--specimen=0.32"}), "of which the drapes of a pool are");
  ExpectOneLineError(run({"--learn", "--images=" + Path("none.png")}), "none.png");
  ExpectOneLineError(
      run({"--learn", up, "--pool_drapes=600"}),
      "option 'pool_drapes': found 600, expected at least 1000 to learn from one sample");
}

TEST_F(PredictTool, MeanImageIsThatOfTheDraws) {
  ASSERT_EQ(Run({"--face=up", "--keep_meshes"}).exit_code, 0);
  MeanImage draws;
  for (int i = 1; i <= 6; ++i) {
    const std::string path = Path("out/draw_" + std::to_string(i) + ".obj");
    if (std::filesystem::exists(path))
      draws.Add(ObserveSurface(ReadObjSurface(path), Camera(), {}, path).image);
  }
  const GrayImage mean = ReadImage(Path("out/mean_image.png")), expected = draws.Mean();
  for (size_t i = 0; i < mean.coverage.size(); ++i)
    ASSERT_NEAR(mean.coverage[i], expected.coverage[i], 0.5 / 255 + 1e-6);
}

TEST_F(PredictTool, DoesNotDependOnTheThreads) {
  ASSERT_EQ(Run({}).exit_code, 0);
  ASSERT_EQ(Run({"--threads=1", "--out=" + Path("one")}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/outlines.json")), Read(Path("one/outlines.json")));
  EXPECT_EQ(Read(Path("out/mean_image.png")), Read(Path("one/mean_image.png")));
  ASSERT_EQ(Run({"--seed=2", "--out=" + Path("two")}).exit_code, 0);
  EXPECT_NE(Read(Path("out/outlines.json")), Read(Path("two/outlines.json")));
}

TEST_F(PredictTool, TakesAFieldOfTables) {
  const Mesh mesh = ParseMeshSpec("disc:120", {});
  Material material = ReadMaterialFor(mesh, kFabric);
  material.field.stretch.resize(mesh.num_faces(), material.field.stretch[0]);
  material.field.bend.resize(mesh.num_hinges(), material.field.bend[0]);
  WriteMaterialField(Path("field.json"), material, mesh);
  ASSERT_EQ(Run({"--draws=2"}).exit_code, 0);
  ASSERT_EQ(Run({"--draws=2", "--fabric=" + Path("field.json"), "--out=" + Path("f")}).exit_code,
            0);
  EXPECT_EQ(Read(Path("out/outlines.json")), Read(Path("f/outlines.json")));
}

class PredictFromAFit : public PredictTool {
 protected:
  // The posterior of a fit of two scales, in the folder "fit".
  StoredPosterior Posterior(double sd) const {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kScales;
    posterior.base = ReadMaterial(kFabric).field;
    posterior.prior_sd = Eigen::VectorXd::Ones(2);
    posterior.mean = Eigen::VectorXd::Zero(2);
    posterior.covariance = sd * sd * Eigen::MatrixXd::Identity(2, 2);
    return posterior;
  }
  void Write(const StoredPosterior& posterior) const {
    std::filesystem::create_directories(Path("fit"));
    WritePosterior(Path("fit"), posterior, "test");
  }
  ProcessResult RunFromFit(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {kPredict,
                                        "--mesh=disc:120",
                                        "--draws=4",
                                        "--steps=60",
                                        "--face=up",
                                        "--threads=2",
                                        "--fabric=" + Path("fit"),
                                        "--out=" + Path("drawn")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, {});
  }
};

// A posterior without spread is its median; one with spread is not.
TEST_F(PredictFromAFit, SpecimensAreDrawsOfThePosterior) {
  Write(Posterior(0.0));
  ASSERT_EQ(Run({"--draws=4", "--face=up"}).exit_code, 0);
  const ProcessResult result = RunFromFit();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Read(Path("out/outlines.json")), Read(Path("drawn/outlines.json")));
  const Json summary = ReadJson(Path("drawn/summary.json"));
  EXPECT_EQ(summary["fabric_source"], Path("fit"));
  EXPECT_EQ(summary["fabric_kind"], "hierarchy");
  Write(Posterior(0.5));
  ASSERT_EQ(RunFromFit().exit_code, 0);
  EXPECT_NE(Read(Path("out/outlines.json")), Read(Path("drawn/outlines.json")));
}

TEST_F(PredictFromAFit, ElementsScatterByModelBdp) {
  StoredPosterior posterior = Posterior(0.0);
  posterior.kind = PosteriorKind::kElements;
  posterior.fabric = ParameterTying::kEntries;
  posterior.prior_sd = Eigen::VectorXd::Ones(39);
  posterior.mean = Eigen::VectorXd::Zero(39);
  posterior.element_sd = Eigen::VectorXd::Constant(39, 0.1);
  Write(posterior);
  const ProcessResult result = RunFromFit({"--specimen_bend_sigma=0.1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(ReadJson(Path("drawn/summary.json"))["fabric_kind"], "bdp");
}

TEST_F(PredictFromAFit, MistakesAreOneLine) {
  ExpectOneLineError(RunFromFit(), "fit");
  Write(Posterior(0.1));
  ExpectOneLineError(RunFromFit({"--learn"}),
                     "'learn' and 'specimens': found 2 of them, expected one of them");
  ExpectOneLineError(RunFromFit({"--specimen_bend_sigma=0.1"}), "expected 0");
  ExpectOneLineError(RunProcess({kPredict, "--fabric=3", "--out=" + Path("drawn")}),
                     "3: no such file; a fabric of the data set is named by --data_fabric");
  EXPECT_FALSE(std::filesystem::exists(Path("drawn")));
}

TEST_F(PredictTool, CtrlCWritesWhatThereIs) {
  const ProcessResult stopped = Run({"--draws=4096", "--data=" + AddData(), "--train=2"},
                                    {.interrupt_when = Path("out"), .interrupt_after = 1.0});
  ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary["outcome"], "cancelled");
  EXPECT_LT(summary["draws"], 4096);
  EXPECT_EQ(summary["provenance"]["options"]["draws"], 4096);
  EXPECT_EQ(summary["drapes"].size(), summary["draws"]);
  EXPECT_EQ(ReadJson(Path("out/outlines.json"))["drapes"].size(), summary["at_rest"]);
}

TEST_F(PredictTool, MistakesAreOneLine) {
  const std::string data = "--data=" + AddData();
  AddDisc("set/data/Fabric 4/silhouettes/Sample_1_Capture_1.png", 0.11);
  AddDisc("set/data/Fabric 4/silhouettes/Sample_2_Capture_1.png", 0.11);
  ExpectOneLineError(Run({"--draws=1"}), "expected a whole number, 2 … 4096");
  ExpectOneLineError(Run({"--draws=9", "--repeats=2"}),
                     "option 'draws': found 9, expected a multiple of 4");
  ExpectOneLineError(Run({"--start_rms=-1"}), "start_rms");
  ExpectOneLineError(Run({"--fabric=" + Path("no.json")}), "no.json");
  ExpectOneLineError(Run({data, "--samples=1-4", "--train=1"}),
                     "found drapes of fabrics 3-4 held out, expected those of one");
  ExpectOneLineError(Run({"--calibrate"}), "option 'calibrate': found true without 'data'");
  ExpectOneLineError(Run({data, "--data_fabric=3", "--train=0", "--calibrate"}),
                     "option 'calibrate': found true with train = 0");
  ExpectOneLineError(Run({data, "--data_fabric=7"}), "fabric: found 7, expected some of 3");
  ExpectOneLineError(Run({"--camera=pinhole", "--camera_width=3"}), "camera_width");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(PredictTool, HelpAndConfigAreComplete) {
  EXPECT_THAT(RunProcess({kPredict, "--help"}).out,
              HasSubstr("usage: drape_predict [--config=FILE]"));
  const std::string config = std::string(DRAPE_SOURCE_DIR) + "/configs/programs/predict.json";
  // The config has been read when the command line is.
  ExpectOneLineError(RunProcess({kPredict, "--config=" + config, "--draws=0"}),
                     "option 'draws': found '0'");
}

}  // namespace
}  // namespace drape::test
