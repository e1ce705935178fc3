// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/readout/place_readouts.h"
#include "losses/readout/scene_readouts.h"
#include "losses/silhouette/silhouette.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/obj_io.h"
#include "physics/util/math/random.h"
#include "solver/fit/fit.h"
#include "solver/fit/observed/experiment_file.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

constexpr const char* kScene =
    R"({"gravity": [0, 0, -9.81], "handles": {"vertices": [0, 4], "stiffness": 1e4}})";

class ExperimentFileTest : public FileFixture {
 protected:
  // A file of one experiment with these measurements.
  std::string WithMeasurements(const std::string& measurements) const {
    return Write("experiment.json",
                 std::string(R"({"density": 0.15, "experiments": [{"mesh": "strip:0.2x0.2x4",)") +
                     R"("scene": )" + kScene + R"(, "measurements": [)" + measurements + "]}]}");
  }
  Experiment Read(const std::string& measurements) const {
    return std::move(ReadExperiments(WithMeasurements(measurements)).experiments.front());
  }
  static ClothModel MakeModel(const Experiment& experiment, const Mesh& mesh) {
    return {mesh, experiment.scene, MakeLaw("smooth")};
  }
  static ClothModel MakeModel(const Experiment& experiment) {
    return MakeModel(experiment, experiment.mesh);
  }

  const MaterialField material_ = LinearMaterial(200.0, 5e-5, 0.15);
};

TEST_F(ExperimentFileTest, MarkersAreReadWhereTheyAreOnTheCloth) {
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.11,0.02,-0.03\n0.2,0.1,0.2,0.1,0\n");
  const Experiment experiment =
      Read(R"({"markers": "m.csv", "sigma": 0.01, "loss": {"huber": 2}})");
  EXPECT_EQ(experiment.name, "experiment_1");
  ASSERT_TRUE(experiment.scene.handles);
  EXPECT_EQ(experiment.scene.handles->vertices, (std::vector{0, 4}));
  const ClothModel model = MakeModel(experiment);
  const std::vector<Sight> sights = MakeSights(experiment, model);
  ASSERT_EQ(sights.size(), 1u);
  EXPECT_EQ(sights[0].readouts.front()->group(), 3);
  const Eigen::VectorXd residual = ReadResiduals(sights[0], material_, model.mesh.rest_x).value();
  EXPECT_LT((residual.head(3) - Eigen::Vector3d(-1, -2, 3)).norm(), 1e-9);
  EXPECT_LT(residual.tail(3).norm(), 1e-9);
  // The first marker is √14 sigma away: by Huber's loss of width 2, ρ = 2·2·√14 − 4.
  EXPECT_NEAR(Misfit(experiment, model, material_, model.mesh.rest_x).value(),
              std::sqrt((4 * std::sqrt(14.0) - 4) / 6), 1e-9);
  EXPECT_EQ(CountResiduals(experiment, model), 6);
}

TEST_F(ExperimentFileTest, AClothOverASupportHasMoreStarts) {
  const auto starts = [&](const std::string& more) {
    Write("m.csv", "vertex,x_m,y_m,z_m\n4,0.05,0,0\n");
    return ReadExperiments(
               Write("e.json", R"({"experiments": [{"mesh": "disc:100", "scene": {"gravity": [0, 0,
        -9.81], "handles": {"region": {"disc": {"radius": 0.09}}, "stiffness": 1e4}})" +
                                   more +
                                   R"(, "measurements": [{"markers": "m.csv", "sigma": 1}]}]})"))
        .experiments.front()
        .random_starts;
  };
  EXPECT_EQ(starts(""), 8);
  EXPECT_EQ(starts(R"(, "random_starts": 1)"), 1);
  Write("m.csv", "vertex,x_m,y_m,z_m\n4,0.05,0,0\n");
  EXPECT_EQ(Read(R"({"markers": "m.csv", "sigma": 1})").random_starts, 2);
}

TEST_F(ExperimentFileTest, ARegisteredShapeIsAStartOfItsOwn) {
  const Mesh mesh = ParseMeshSpec("strip:0.2x0.2x4");
  Eigen::VectorXd x = mesh.rest_x;
  for (Eigen::Index i = 2; i < x.size(); i += 3) x[i] = -0.1 * x[i - 2];
  WriteObj(Path("scan.obj"), mesh, x);
  const Experiment experiment = Read(R"({"shape": "scan.obj", "sigma": 0.002})");
  EXPECT_LT((experiment.start - x).norm(), 1e-6);
  EXPECT_LT(Misfit(experiment, MakeModel(experiment), material_, x).value(), 1e-3);
  // On another mesh of the cloth too.
  const Mesh finer = ParseMeshSpec("strip:0.2x0.2x8");
  Eigen::VectorXd same = finer.rest_x;
  for (Eigen::Index i = 2; i < same.size(); i += 3) same[i] = -0.1 * same[i - 2];
  const ClothModel model = MakeModel(experiment, finer);
  EXPECT_LT(Misfit(experiment, model, material_, same).value(), 1e-3);
  EXPECT_LT((MakeStart(experiment, model, 0).x - same).norm(), 1e-6);
  EXPECT_EQ(StartAt(experiment, model, ListStarts(experiment)[2]).x,
            MakeStart(experiment, model, 2).x);
}

TEST_F(ExperimentFileTest, PointsDrawClothAndClothDrawsPoints) {
  Write("p.csv", "x,y,z\n0.1,0.0,0.003\n0.05,0.05,0.0\n");
  const Experiment experiment =
      Read(R"({"points": "p.csv", "sigma": 0.001, "spacing": 0.02, "max_distance": 0.05})");
  const ClothModel model = MakeModel(experiment);
  const std::vector<Sight> sights = MakeSights(experiment, model);
  ASSERT_EQ(sights.size(), 2u);
  EXPECT_EQ(sights[0].data.size(), 6);
  EXPECT_EQ(sights[1].data.size(), experiment.mesh.num_vertices());
  const Eigen::VectorXd residual = ReadResiduals(sights[0], material_, model.mesh.rest_x).value();
  EXPECT_NEAR(residual.norm(), 3.0, 1e-9);
}

TEST_F(ExperimentFileTest, ForcesAndFrequenciesAreOfTheScene) {
  const Experiment experiment = Read(
      R"({"force": [0, 0, 0.01], "sigma": 0.001}, {"force": 0.02, "along": [0, 0, 2], "vertices": [4],
          "sigma": 0.01}, {"frequencies": [2.5, 4], "modes": [1, 3], "sigma": 0.1})");
  ClothModel model = MakeModel(experiment);
  Eigen::VectorXd x = model.mesh.rest_x;
  x[2] -= 1e-6;
  x[14] -= 2e-6;
  const std::vector<Sight> sights = MakeSights(experiment, model);
  ASSERT_EQ(sights.size(), 3u);
  EXPECT_TRUE(experiment.in_newtons);
  EXPECT_LT((*ReadResiduals(sights[0], material_, x) - Eigen::Vector3d(0, 0, 20)).norm(), 1e-9);
  EXPECT_NEAR((*ReadResiduals(sights[1], material_, x))[0], 0.0, 1e-9);
  EXPECT_EQ(sights[2].readouts.front()->size(), 2);
  EXPECT_EQ(sights[2].data, Eigen::Vector2d(2.5, 4));
}

// A fitted number that no experiment shows is refused.
TEST_F(ExperimentFileTest, WhatIsFittedHasToBeSeen) {
  const auto read = [&](const std::string& fit, const std::string& more,
                        const std::string& measurement) {
    return ReadExperiments(
        Write("e.json", R"({"fit": [")" + fit +
                            R"("], "experiments": [{"mesh": "strip:0.2x0.2x4",)" + R"("scene": )" +
                            kScene + more + R"(, "measurements": [)" + measurement + "]}]}"));
  };
  const std::string force = R"({"force": 1, "along": [0, 0, 1], "sigma": 0.1})",
                    angle = R"({"angle": 30, "tip": [4], "clamp": [0, 0, 0], "along": [1, 0, 0],
                                "sigma": 1, "step": 2})";
  EXPECT_EQ(read("density", "", force).fitted, std::vector{FreeNumber::kDensity});
  EXPECT_INPUT_ERROR(read("mass", "", force), "density, mass_damping, stiffness_damping");
  EXPECT_INPUT_ERROR(read("velocity", "", force), "none without a motion");
  EXPECT_INPUT_ERROR(read(R"(density", "density)", "", force), "'fit[1]': found \"density\"");
  const std::string still = R"(, "motion": {"steps": 2, "time_step": 0.01})";
  EXPECT_EQ(read("velocity", still, angle).fitted, std::vector{FreeNumber::kVelocity});
  EXPECT_INPUT_ERROR(read("wind", still, angle), "air_drag");
  EXPECT_INPUT_ERROR(read("air_drag", still, angle), "a start value of it");
  EXPECT_INPUT_ERROR(read("velocity", still, R"({"frequencies": [2], "sigma": 1, "step": 2})"),
                     "expected a cloth at rest");
}

// Names and frames follow from what is given.
TEST_F(ExperimentFileTest, ExperimentsInMemoryAreCompleted) {
  Write("m.csv", "vertex,x_m,y_m,z_m\n4,0.05,0,0\n");
  ExperimentFile file{.material = "", .experiments = {Read(R"({"markers": "m.csv", "sigma": 1})")}};
  Experiment& experiment = file.experiments[0];
  experiment.name.clear();
  experiment.motion = RolloutOptions{.h = 0.01, .steps = 5};
  experiment.measurements.resize(3, experiment.measurements[0]);
  experiment.measurements[0].step = 4;
  experiment.scene.load = EdgeLoad{HalfPlaneRegion{}, Eigen::Vector3d::UnitX()};
  CompleteExperiments(file, "memory");
  EXPECT_EQ(experiment.name, "experiment_1");
  EXPECT_EQ(experiment.motion->frames, (std::vector{0, 4}));
  EXPECT_TRUE(experiment.in_newtons);
  EXPECT_EQ(MakeSights(experiment, MakeModel(experiment))[0].frame, 1);
  experiment.measurements[0].step = 6;
  EXPECT_INPUT_ERROR(CompleteExperiments(file, "memory"), "m.csv: found step 6, expected 0 … 5");
  experiment.motion->h = 0.0;
  EXPECT_INPUT_ERROR(CompleteExperiments(file, "memory"),
                     "memory: key 'experiments[0]': found time_step 0, expected 1e-06 … 10");
}

// All derivatives of one cloth whose density is free, at rest and in motion, by differences.
TEST(FreeNumbers, ResidualsHaveTheirDerivatives) {
  const auto model = std::make_shared<const ClothModel>(
      MakeStrip(0.12, 0.04, 8, 3), CantileverScene(0.016, 9.81), MakeLaw("smooth"));
  const auto backend = MakeCpuBackend(model, 1);
  MaterialField base = test::TestMaterial();
  base.dynamics = {.mass_damping = 1.0, .air_drag = 0.8, .wind = {0.5, 1.0, 2.0}};
  const auto sight = [&](std::shared_ptr<const Readout> readout) {
    return Sight{.readouts = {readout}, .data = Eigen::VectorXd::Zero(readout->size())};
  };
  RolloutBlock rest{
      .runs = {{.backend = backend.get(), .start = {}}},
      .sights = {sight(std::make_shared<FrequencyReadout>(*model, std::vector{1, 2})),
                 sight(std::make_shared<HandleForceReadout>(*model, std::vector{model->held[0]},
                                                            Eigen::Matrix3d::Identity()))},
      .is_unique = true};
  rest.prepare = [](MaterialField fabric) {
    fabric.density *= 0.7;
    return fabric;
  };
  RolloutBlock motion{.runs = {{.backend = backend.get(), .start = model->RestState()}},
                      .sights = {sight(std::make_shared<PositionReadout>(model->mesh))},
                      .solve_mode = SolveMode::kDynamic,
                      .rollout = {.h = 0.02, .steps = 6},
                      .is_unique = true};
  using enum FreeNumber;
  const TableParametrisation table(base, ParameterTying::kScales);
  const DynamicsParametrisation all(table, {kVelocity, kDensity, kMassDamping, kAirDrag, kWind}),
      only_table(table, {});
  const auto check = [](const MaterialParametrisation& parametrisation, const RolloutBlock& block,
                        double tolerance) {
    RolloutResiduals residuals(&parametrisation, {block}, {});
    residuals.PrepareForEvaluation(true, true);
    ASSERT_TRUE(residuals.all_valid());
    const RowMatrix jacobian = residuals.jacobian(0);
    for (int i = 0; i < residuals.num_parameters(); ++i) {
      constexpr double kStep = 1e-4;
      Eigen::VectorXd at[2];
      for (const int side : {0, 1}) {
        residuals.theta()[i] = side == 0 ? kStep : -kStep;
        residuals.PrepareForEvaluation(false, true);
        ASSERT_TRUE(residuals.all_valid());
        at[side] = residuals.residual(0);
      }
      residuals.theta()[i] = 0.0;
      const Eigen::VectorXd differences = (at[0] - at[1]) / (2 * kStep);
      EXPECT_LT((jacobian.col(i) - differences).norm(), tolerance * jacobian.norm()) << i;
    }
  };
  check(all, rest, 1e-5);
  check(only_table, rest, 1e-5);
  check(all, motion, 1e-6);
}

// A coarser mesh of the same cloth, of which all can be read that is measured.
TEST_F(ExperimentFileTest, TheBranchIsSoughtOnAnotherMeshOfTheCloth) {
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.1,0,0\n");
  Write("v.csv", "vertex,x_m,y_m,z_m\n4,0.05,0,0\n");
  const std::string markers = R"({"markers": "m.csv", "sigma": 0.01})";
  const auto read = [&](const std::string& search, const std::string& more,
                        const std::string& measurement, bool by_region = true) {
    const std::string region =
        R"({"gravity": [0, 0, -9.81], "handles": {"region": {"half_plane": {"offset": 0.06}},
                                                  "stiffness": 1e4}})";
    const std::string text = R"({"experiments": [{"mesh": "strip:0.2x0.2x8", "search_mesh": ")" +
                             search + R"(", "scene": )" + (by_region ? region : kScene) + more +
                             R"(, "measurements": [)" + measurement + "]}]}";
    return std::move(ReadExperiments(Write("e.json", text)).experiments.front());
  };
  const Experiment experiment = read("strip:0.2x0.2x4", "", markers);
  EXPECT_EQ(experiment.search_mesh.num_vertices(), ParseMeshSpec("strip:0.2x0.2x4").num_vertices());
  const auto by_default = [&](const std::string& mesh, bool by_region) {
    const std::string scene = by_region ? R"({"gravity": [0, 0, -9.81], "handles": {"region":
                                   {"half_plane": {"offset": 0.02}}, "stiffness": 1e4}})"
                                        : std::string(kScene);
    const std::string text = R"({"experiments": [{"mesh": ")" + mesh + R"(", "scene": )" + scene +
                             R"(, "measurements": [)" + markers + "]}]}";
    return ReadExperiments(Write("e.json", text)).experiments.front().search_mesh.num_vertices();
  };
  EXPECT_EQ(by_default("strip:0.2x0.2x20", true), ParseMeshSpec("strip:0.2x0.2x10").num_vertices());
  EXPECT_EQ(by_default("strip:0.2x0.2x20", false), 0);
  EXPECT_EQ(by_default("strip:0.2x0.2x10", true), 0);
  EXPECT_INPUT_ERROR(read("strip:0.2x0.3x4", "", markers),
                     "e.json: key 'experiments[0]': key 'search_mesh': found another cloth");
  EXPECT_INPUT_ERROR(read("strip:0.2x0.2x8", "", markers), "expected fewer than the");
  EXPECT_INPUT_ERROR(read("strip:0.2x0.2x4", "", R"({"markers": "v.csv", "sigma": 1})"),
                     "by numbers of vertices, expected no search_mesh");
  EXPECT_INPUT_ERROR(read("strip:0.2x0.2x4", "", markers, false), "handles by numbers");
  EXPECT_INPUT_ERROR(read("strip:0.2x0.2x4", R"(, "motion": {"steps": 2, "time_step": 0.01})",
                          R"({"markers": "m.csv", "sigma": 0.01, "step": 2})"),
                     "found a motion, whose branch is not sought");
}

// A picture of a drape from above with its camera.
TEST_F(ExperimentFileTest, AnOutlineIsReadInMetres) {
  const auto read = [&](const std::string& mesh, const std::string& scene) {
    const std::string measurement =
        R"({"outline": "drape.png", "camera_file": "camera.json", "sigma": 0.002})";
    return std::move(
        ReadExperiments(Write("e.json", R"({"experiments": [{"mesh": ")" + mesh +
                                            R"(", "scene": )" + scene + R"(, "measurements": [)" +
                                            measurement + "]}]}"))
            .experiments.front());
  };
  const std::string support = R"({"gravity": [0, 0, -9.81], "handles": {"region": {"disc":
                                  {"radius": 0.09}}, "stiffness": 1e4}})";
  const Mesh mesh = ParseMeshSpec("disc:300");
  const Camera camera;
  Write("camera.json", CameraJson(camera).dump());
  Eigen::VectorXd x = mesh.rest_x;
  for (int v = 0; v < mesh.num_vertices(); ++v)
    if (mesh.uv.col(v).norm() > 0.1) x.segment<2>(3 * v) *= 0.9;
  WritePng(Rasterize(mesh, mesh.rest_x, camera, 4), Path("drape.png"));
  const Experiment experiment = read("disc:300", support);
  const ClothModel model = MakeModel(experiment);
  EXPECT_LT(Misfit(experiment, model, material_, mesh.rest_x).value(), 0.1);
  EXPECT_NEAR(Misfit(experiment, model, material_, x).value(), 0.015 / 0.002, 0.1);
  EXPECT_INPUT_ERROR(read("disc:300", kScene), "outline': found \"drape.png\", expected none");
  EXPECT_INPUT_ERROR(read("disc:300,radius=0.12", support), "measurements[0].outline': ");
}

TEST_F(ExperimentFileTest, BadInputIsOneLineWithItsKey) {
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.5,0.0,0.1,0,0\n");
  Write("good.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.1,0,0\n");
  const std::string good = R"("markers": "good.csv")";
  EXPECT_INPUT_ERROR(Read(R"({"markers": "m.csv", "sigma": 0.01})"), "m.csv");
  EXPECT_INPUT_ERROR(Read("{" + good + "}"), "sigma");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 0})"), "measurements[0].sigma");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "loss": {"l1": 2}})"), "loss");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "loss": {}})"), "huber, cauchy and tukey");
  EXPECT_INPUT_ERROR(Read(R"({"marker": "good.csv", "sigma": 1})"), "one of markers");
  EXPECT_INPUT_ERROR(Read("{" + good + R"(, "sigma": 1, "x": 2})"), "'experiments[0]");
  EXPECT_INPUT_ERROR(Read(""), "at least one measurement");
  EXPECT_INPUT_ERROR(
      Read(R"({"angle": 30, "tip": [99], "clamp": [0, 0, 0], "along": [1, 0, 0], "sigma": 1})"),
      "tip[0]");
  EXPECT_INPUT_ERROR(
      Read(R"({"angle": 30, "tip": [4], "clamp": [0, 0, 0], "along": [1, 0, 1], "sigma": 1})"),
      "a horizontal direction");
  EXPECT_INPUT_ERROR(Read(R"({"force": 1, "along": [0, 0, 0], "sigma": 1})"), "a direction");
  EXPECT_INPUT_ERROR(Read(R"({"force": [0, 1], "sigma": 1})"), "force");
  EXPECT_INPUT_ERROR(Read(R"({"force": [0, 1, 2], "vertices": [0, 3], "sigma": 1})"),
                     "vertices[1]");
  EXPECT_INPUT_ERROR(Read(R"({"frequencies": [], "sigma": 1})"), "at least one frequency");
  EXPECT_INPUT_ERROR(Read(R"({"frequencies": [2, -1], "sigma": 1})"), "each more than 0");
  EXPECT_INPUT_ERROR(Read(R"({"frequencies": [2, 3], "modes": [1], "sigma": 1})"), "modes");
  EXPECT_INPUT_ERROR(Read(R"({"frequencies": [2], "modes": [0], "sigma": 1})"), "modes[0]");
  std::string points = "x,y,z\n";
  for (int i = 0; i < 90000; ++i) points += "0,0,0\n";
  Write("many.csv", points);
  EXPECT_INPUT_ERROR(Read(R"({"points": "many.csv", "sigma": 1})"), "at most 262144");
  EXPECT_INPUT_ERROR(ReadExperiments(Write("e.json", R"({"experiments": []})")),
                     "at least one experiment");
  EXPECT_INPUT_ERROR(
      ReadExperiments(Write("e.json", R"({"experiments": [{"name": "../x", "mesh": "disc:100",
                                          "scene": {}, "measurements": []}]})")),
      "e.json: key 'experiments[0]': found name '../x'");
  EXPECT_INPUT_ERROR(
      ReadExperiments(Write("e.json", R"({"experiments": [{"mesh": "strip:0.2.x005x4"}]})")),
      "e.json: key 'experiments[0].mesh': strip:0.2.x005x4");
}

// A wrong outline is not made up for by the pixels that all drapes cover, or none.
TEST_F(ExperimentFileTest, PixelsAtTheOutlineOfASilhouetteCount) {
  GrayImage image(64, 64);
  for (int y = 20; y < 40; ++y)
    for (int x = 10; x < 50; ++x) image.at(x, y) = 1.0;
  WritePng(image, Path("side.png"));
  Camera camera;
  camera.width = camera.height = 64;
  const Experiment experiment =
      Read(R"({"silhouette": "side.png", "sigma": 1, "view": )" + CameraJson(camera).dump() + "}");
  const int inside = 2 * (40 + 20) - 4, outside = 2 * (40 + 20);
  EXPECT_EQ(CountResiduals(experiment, MakeModel(experiment)), inside + outside);
  // Neighbours on a contour err together: for intervals it is 36 numbers, and markers are as
  // before.
  EXPECT_EQ(CountIndependent(MakeSights(experiment, MakeModel(experiment))[0]), 36);
  EXPECT_NEAR(ForIntervals(experiment).measurements[0].sigma, std::sqrt((inside + outside) / 36.0),
              1e-12);
  Write("m.csv", "weft_m,warp_m,x_m,y_m,z_m\n0.1,0.0,0.1,0,0\n");
  const Experiment markers = Read(R"({"markers": "m.csv", "sigma": 0.01})");
  EXPECT_EQ(CountIndependent(MakeSights(markers, MakeModel(markers))[0]), 3);
  EXPECT_EQ(ForIntervals(markers).measurements[0].sigma, 0.01);
  Experiment coarse = markers;
  coarse.mesh_factor = EnlargeByCommon(0.5, 3);
  EXPECT_NEAR(ForIntervals(coarse).measurements[0].sigma, 0.01 * std::sqrt(1.5), 1e-15);
  coarse.step_factor = EnlargeByCommon(1.0, 3);
  EXPECT_NEAR(ForIntervals(coarse).measurements[0].sigma, 0.01 * std::sqrt(2.5), 1e-15);
  EXPECT_NEAR(EnlargeByCommon(0.5, 24), std::sqrt(2.0), 1e-15);
}

// Seen from the side a cloth may arch over its middle, have holes and come in parts. A picture with
// grey levels could be of anything.
TEST_F(ExperimentFileTest, ASilhouetteFromTheSideIsReadAsItIs) {
  GrayImage image(64, 64);
  const auto fill = [&](int left, int top, int right, int bottom, float coverage) {
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) image.at(x, y) = coverage;
  };
  for (const bool solid : {false, true}) {  // within an edge of mixed pixels
    const int edge = solid ? 0 : 1;
    const float coverage = solid ? 1.0f : 0.6f;
    fill(8 - edge, 10 - edge, 56 + edge, 14 + edge, coverage);  // an arch
    fill(8 - edge, 14, 16 + edge, 50 + edge, coverage);         // with two legs
    fill(48 - edge, 14, 56 + edge, 50 + edge, coverage);        // one of which
    fill(51, 20, 53, 22, 0.0f);                                 // has a hole
    fill(26 - edge, 40, 34 + edge, 50 + edge, coverage);        // a part in front
  }
  WritePng(image, Path("side.png"));
  Camera camera;
  camera.width = camera.height = 64;
  const std::string fit =
      R"({"silhouette": "side.png", "sigma": 1, "view": )" + CameraJson(camera).dump() + "}";
  const Eigen::VectorXd read = Read(fit).measurements[0].data;
  for (Eigen::Index i = 0; i < read.size(); ++i)
    ASSERT_NEAR(read[i], image.coverage[i], 0.003) << i % 64 << ", " << i / 64;
  fill(0, 0, 64, 5, 0.4f);
  WritePng(image, Path("side.png"));
  EXPECT_INPUT_ERROR(Read(fit), "silhouette': " + Path("side.png") +
                                    ": a picture with grey levels, expected a mask");
}

// Who reads of a file that is missing or wrong also reads which key led to it.
TEST_F(ExperimentFileTest, AnErrorOfAnotherFileNamesTheKey) {
  EXPECT_INPUT_ERROR(Read(R"({"markers": "none.csv", "sigma": 1})"),
                     "experiment.json: key 'experiments[0].measurements[0].markers': ");
  EXPECT_INPUT_ERROR(Read(R"({"points": "none.ply", "sigma": 1})"), "measurements[0].points': ");
  EXPECT_INPUT_ERROR(Read(R"({"silhouette": "none.png", "view": "none.json", "sigma": 1})"),
                     "silhouette': ");
  WriteObj(Path("scan.obj"), ParseMeshSpec("strip:0.2x0.2x5"),
           ParseMeshSpec("strip:0.2x0.2x5").rest_x);
  EXPECT_INPUT_ERROR(Read(R"({"shape": "scan.obj", "sigma": 1})"), "shape': found");
  EXPECT_INPUT_ERROR(
      ReadExperiments(
          Write("e.json", R"({"experiments": [{"mesh": "strip:0.2x0.05x4", "scene": "swing"}]})")),
      "e.json: key 'experiments[0].scene': ");
  EXPECT_INPUT_ERROR(ReadExperiments(Write("e.json", R"({"experiments": [{"mesh":
      "strip:0.2x0.05x4", "measurements": [{}], "scene": {"load": {"region": {"disc":
      {"radius": 0.01, "centre": [9, 0]}}, "force": [1, 0, 0]}}}]})")),
                     "'experiments[0].scene': scene: found no edge of the hem");
}

// Chance widens nothing; what is more widens many numbers more than few, as twelve in common would.
TEST(EnlargeSigma, TakesWhatIsMoreThanChanceAsCommon) {
  EXPECT_EQ(EnlargeSigma(0.3, 10), 1.0);
  EXPECT_EQ(EnlargeSigma(1.04, 900), 1.0);
  EXPECT_EQ(EnlargeSigma(1.2, 40), 1.0);
  EXPECT_NEAR(EnlargeSigma(3.0, 5), std::sqrt(10.0 - std::pow(1.0 + 2.0 / std::sqrt(10.0), 2)),
              1e-12);
  EXPECT_NEAR(EnlargeSigma(2.0, 1'200'000), 316.2 * std::sqrt(3.0), 1.0);
  EXPECT_GT(EnlargeSigma(1.5, 900), 9.0);
}

// Half the squares are the cost of the loss, of which their Jacobian gives the gradient.
TEST(RobustBlocks, SquaresAreTheLoss) {
  const auto model =
      std::make_shared<const ClothModel>(MakeStrip(0.1, 0.05, 1, 1), Scene(), MakeLaw("smooth"));
  Sight sight{.readouts = {std::make_shared<MarkerReadout>(
                  WeightsOfPlaces(model->mesh, model->mesh.uv.leftCols(3), ""))},
              .data = {}};
  const Eigen::VectorXd theta = Eigen::Vector3d(0.3, -0.2, 0.5);
  std::mt19937_64 random(3);
  Eigen::MatrixXd slope(9, 3);
  Eigen::VectorXd at_zero(9);
  for (double& value : slope.reshaped()) value = SampleNormal(random);
  for (double& value : at_zero) value = SampleNormal(random);
  at_zero.head(3) = -slope.topRows(3) * theta;  // a marker that is met
  at_zero.tail(3) *= 20.0;                      // one that is far off
  const std::shared_ptr<ceres::LossFunction> losses[] = {std::make_shared<ceres::HuberLoss>(2.0),
                                                         std::make_shared<ceres::CauchyLoss>(2.0),
                                                         std::make_shared<ceres::TukeyLoss>(9.0)};
  for (const auto& loss : losses) {
    sight.loss = loss;
    const auto weigh = [&](const Eigen::VectorXd& at, Eigen::VectorXd* residual,
                           Eigen::MatrixXd* jacobian) {
      *residual = at_zero + slope * at;
      if (jacobian == nullptr) return WeighByLoss(sight, *residual, nullptr);
      *jacobian = slope;
      Eigen::Ref<Eigen::MatrixXd> scaled = *jacobian;
      return WeighByLoss(sight, *residual, &scaled);
    };
    Eigen::VectorXd residual, ahead, behind;
    Eigen::MatrixXd jacobian;
    const double cost = weigh(theta, &residual, &jacobian);
    EXPECT_NEAR(0.5 * residual.squaredNorm(), cost, 1e-12 * cost);
    double least_rho[3];
    loss->Evaluate((at_zero + slope * theta).tail(3).squaredNorm(), least_rho);
    EXPECT_GT(cost, 0.5 * least_rho[0]);
    for (int i = 0; i < 3; ++i) {
      constexpr double kStep = 1e-6;
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(3, i);
      (void)weigh(theta + step, &ahead, nullptr);
      (void)weigh(theta - step, &behind, nullptr);
      EXPECT_LT(((ahead - behind) / (2 * kStep) - jacobian.col(i)).norm(), 1e-8) << i;
    }
  }
}

// A cost with a loss is what Ceres makes of it: from far outliers the fit turns away.
TEST(RobustBlocks, AnOutlierIsPassedBy) {
  const auto model = std::make_shared<const ClothModel>(
      MakeStrip(0.2, 0.05, 12, 4), CantileverScene(0.01, 9.81), MakeLaw("smooth"));
  const auto backend = MakeCpuBackend(model, 1);
  const MaterialField reference = LinearMaterial(200.0, 5e-5, 0.2);
  const EquilibriumResult rest = SolveFromRest(*backend, reference, {});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  const auto fitted = [&](std::shared_ptr<ceres::LossFunction> loss) {
    Eigen::VectorXd data = rest.x;
    data[data.size() - 1] -= 0.2;
    const TableParametrisation scales(Scaled(reference, 1.0, 0.7), ParameterTying::kBendScale);
    RolloutBlock block{.runs = {{.backend = backend.get(), .start = {rest.x, {}}}},
                       .sights = {{.readouts = {std::make_shared<PositionReadout>(model->mesh)},
                                   .data = data,
                                   .sigma = 1e-3,
                                   .loss = std::move(loss)}}};
    ResidualOptions options;
    options.max_outline_change = options.max_jump = 1e9;
    RolloutResiduals residuals(&scales, {block}, options);
    FitOptions fit;
    fit.prior_sigma = 10.0;
    fit.trust_region.cost_tolerance = 1e-10;
    const FitSummary summary = Fit(residuals, fit);
    // The cost that is reported is that which Ceres lowered.
    EXPECT_NEAR(summary.final_cost, summary.iterations.back().cost,
                1e-6 * summary.final_cost + 1e-9);
    return std::exp(summary.theta[0]) * 0.7;
  };
  EXPECT_GT(std::abs(fitted(nullptr) - 1.0), 0.02);
  EXPECT_NEAR(fitted(std::make_shared<ceres::TukeyLoss>(5.0)), 1.0, 1e-3);
}

}  // namespace
}  // namespace drape
