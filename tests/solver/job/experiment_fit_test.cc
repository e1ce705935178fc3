// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iomanip>
#include <random>

#include "losses/readout/place_readouts.h"
#include "losses/readout/scene_readouts.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/math/random.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape::test {
namespace {

// A square that hangs from two corners, made on another mesh with other tables, and a cantilever of
// the same fabric.
class ExperimentFitTest : public FitJobTest {
 protected:
  static constexpr const char* kCorners =
      R"({"gravity": [0, 0, -9.81], "handles": {"stiffness": 1e4, "regions": [
          {"disc": {"radius": 0.004, "centre": [0, 0.1]}},
          {"disc": {"radius": 0.004, "centre": [0.2, 0.1]}}]}})";

  ExperimentFitTest() {
    data_.images.clear();
    spec_.stages.grid.bend = {1.0};
    spec_.stages.parameters = ParameterTying::kScales;
    spec_.stages.iterations = {12};
    std::ofstream(folder_ / "corners.json") << kCorners;
    WriteMarkers();
  }
  // Of a cloth of four times the bending stiffness and half the stretching stiffness.
  void WriteMarkers() {
    const auto model = std::make_shared<const ClothModel>(
        ParseMeshSpec("strip:0.2x0.2x14"), ReadScene(folder_ / "corners.json"), MakeLaw("smooth"));
    const auto backend = MakeCpuBackend(model, 1);
    const State drape = Settled(*backend, Scaled(TestMaterial(), 0.5, 4.0), model->RestState());
    Eigen::Matrix2Xd places(2, 25);
    for (int i = 0; i < 25; ++i)
      places.col(i) << 0.02 + 0.04 * (i % 5), -0.08 + 0.04 * double(i / 5);
    Eigen::VectorXd x;
    ASSERT_TRUE(MarkerReadout(WeightsOfPlaces(model->mesh, places, "")).Read(drape.x, &x, nullptr));
    std::mt19937_64 random(5);
    std::ofstream file(folder_ / "markers.csv");
    file << "weft_m,warp_m,x_m,y_m,z_m\n";
    for (int i = 0; i < 25; ++i) {
      file << places(0, i) << "," << places(1, i);
      for (int d = 0; d < 3; ++d) file << "," << x[3 * i + d] + 5e-4 * SampleNormal(random);
      file << "\n";
    }
  }
  void WriteExperiments(const std::string& more = "") {
    data_.experiment = folder_ / "experiment.json";
    std::ofstream(data_.experiment)
        << R"({"experiments": [{"name": "square", "mesh": "strip:0.2x0.2x10",)"
        << R"("scene": "corners.json", "random_starts": 1,)"
        << R"("measurements": [{"markers": "markers.csv", "sigma": 5e-4}]})" << more << "]}";
  }
};

TEST_F(ExperimentFitTest, MarkersGiveTheStiffnessOfAnotherMesh) {
  WriteExperiments();
  RunControl control;
  std::string said;
  control.log = [&](const std::string& line) { said += line + "\n"; };
  const FitJobResult result = RunFitJob(spec_, data_, files_, control);
  ASSERT_TRUE(result.fitted);
  EXPECT_NE(said.find("this experiment determines"), std::string::npos) << said;
  const nlohmann::json summary = Summary();
  const MaterialField fitted = ReadMaterial(folder_ / "material.json").field;
  const MaterialField reference = Scaled(TestMaterial(), 0.5, 4.0);
  EXPECT_NEAR(fitted.stretch[0].c[0][0] / reference.stretch[0].c[0][0], 1.0, 0.15);
  EXPECT_NEAR(fitted.bend[0].b[0][0] / reference.bend[0].b[0][0], 1.0, 0.3);
  EXPECT_LT(summary["measurements"][0]["misfit_sigma"], 1.5);
  EXPECT_EQ(summary["measurements"][0]["numbers"], 75);
  EXPECT_TRUE(std::filesystem::exists(std::string(folder_ / "drape_square.obj")));
  EXPECT_NE(result.table.find("markers of"), std::string::npos);
}

// A second cloth of the fabric, whose reading contradicts none of the markers.
TEST_F(ExperimentFitTest, TwoExperimentsAreOneFit) {
  WriteExperiments(
      R"(, {"name": "strip", "mesh": "strip:0.06x0.02x12",
           "scene": {"gravity": [0, 0, -9.81], "handles": {"region": {"half_plane": {"offset": 0.006}}, "stiffness": 1e4}},
           "measurements": [{"angle": 30, "tip": [12], "clamp": [0.005, 0, 0], "along": [1, 0, 0],
                             "sigma": 5}]})");
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json measurements = Summary()["measurements"];
  ASSERT_EQ(measurements.size(), 2u);
  EXPECT_EQ(measurements[1]["experiment"], "strip");
  EXPECT_EQ(measurements[1]["numbers"], 1);
}

// Strips that move and strips at rest, held at an end.
class StripFitTest : public ExperimentFitTest {
 protected:
  std::shared_ptr<const ClothModel> MakeModel(const std::string& mesh, const std::string& scene) {
    std::ofstream(folder_ / "held.json") << scene;
    return std::make_shared<const ClothModel>(ParseMeshSpec(mesh), ReadScene(folder_ / "held.json"),
                                              MakeLaw("smooth"));
  }
  static constexpr const char* kHeldEdge =
      R"({"gravity": [0, 0, -9.81],
          "handles": {"region": {"half_plane": {"offset": 0.001}}, "stiffness": 1e3}})";

  // Measurements of a motion that begins flat with that velocity [m/s]: places of the cloth in
  // every frame.
  nlohmann::json Film(const ClothModel& model, const MaterialField& reference,
                      const Eigen::Vector3d& velocity, const RolloutOptions& steps) {
    State start = model.RestState();
    start.v = velocity.replicate(model.mesh.num_vertices(), 1);
    const RolloutInput input{&reference, &start};
    const RolloutResult seen = MakeCpuBackend(std::make_shared<const ClothModel>(model), 1)
                                   ->Rollouts({&input, 1}, steps, nullptr)
                                   .front();
    EXPECT_EQ(seen.status, RolloutStatus::kOk);
    Eigen::Matrix2Xd places(2, 8);
    for (int i = 0; i < 8; ++i) places.col(i) << 0.035 * (1 + i / 2), i % 2 == 0 ? -0.01 : 0.01;
    const MarkerReadout markers(WeightsOfPlaces(model.mesh, places, ""));
    nlohmann::json measurements;
    for (std::size_t k = 0; k < steps.frames.size(); ++k) {
      const std::string name = "frame" + std::to_string(k) + ".csv";
      Eigen::VectorXd x;
      EXPECT_TRUE(markers.Read(seen.frames[k].x, &x, nullptr));
      std::ofstream file(folder_ / name);
      file << "weft_m,warp_m,x_m,y_m,z_m\n" << std::setprecision(17);
      for (int i = 0; i < 8; ++i)
        file << places(0, i) << "," << places(1, i) << "," << x[3 * i] << "," << x[3 * i + 1] << ","
             << x[3 * i + 2] << "\n";
      measurements.push_back({{"markers", name}, {"sigma", 1e-4}, {"step", steps.frames[k]}});
    }
    return measurements;
  }
  // The fit of one experiment on a mesh.
  void FitStrip(const std::string& mesh, const nlohmann::json& motion,
                const nlohmann::json& measurements, const std::vector<std::string>& fit) {
    data_.experiment = folder_ / "experiment.json";
    nlohmann::json strip = {
        {"name", "strip"}, {"mesh", mesh}, {"scene", "held.json"}, {"measurements", measurements}};
    if (!motion.empty()) strip["motion"] = motion;
    std::ofstream(data_.experiment) << nlohmann::json{{"fit", fit}, {"experiments", {strip}}};
    ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
    const nlohmann::json summary = Summary();
    fitted_ = summary.value("dynamics", nlohmann::json::object());
    ASSERT_FALSE(summary["measurements"].empty());
    for (const nlohmann::json& each : summary["measurements"])
      EXPECT_LT(each["misfit_sigma"], 1.0) << each;
  }
  double Value(const char* name) const { return fitted_[name]["value"]; }
  // The bending stiffness by that of the start tables.
  double Bend() const {
    return ReadMaterial(folder_ / "material.json").field.bend[0].b[0][0] /
           TestMaterial().bend[0].b[0][0];
  }

  nlohmann::json fitted_;
};

// A strip that swings down, seen in six frames, gives damping and drag beside its stiffness.
TEST_F(StripFitTest, AMotionGivesDampingAndDrag) {
  MaterialField reference = Scaled(TestMaterial(), 1.0, 3.0);
  reference.dynamics = {.mass_damping = 2.0, .air_drag = 1.0};
  const auto model = MakeModel("strip:0.15x0.03x10", kHeldEdge);
  const nlohmann::json film = Film(*model, reference, Eigen::Vector3d::Zero(),
                                   {.h = 0.02, .steps = 30, .frames = {5, 10, 15, 20, 25, 30}});
  FitStrip("strip:0.15x0.03x10",
           {{"steps", 30}, {"time_step", 0.02}, {"mass_damping", 1.0}, {"air_drag", 0.3}}, film,
           {"mass_damping", "air_drag"});
  EXPECT_NEAR(Value("mass_damping"), 2.0, 0.1) << fitted_;
  EXPECT_NEAR(Value("air_drag"), 1.0, 0.1);
  EXPECT_NEAR(Bend(), 3.0, 0.3);
}

// Models that the fitted one contains belong to a search, and a motion has none.
TEST_F(StripFitTest, AMotionKeepsTheTablesThatWereFitted) {
  const auto model = MakeModel("strip:0.15x0.03x6", kHeldEdge);
  const nlohmann::json film =
      Film(*model, Scaled(TestMaterial(), 1.0, 2.0), Eigen::Vector3d::Zero(),
           {.h = 0.02, .steps = 10, .frames = {5, 10}});
  spec_.stages.parameters = ParameterTying::kColumns;
  std::vector<std::vector<uint8_t>> materials;
  for (const bool simpler : {false, true}) {
    spec_.simpler_models = simpler;
    FitStrip("strip:0.15x0.03x6", {{"steps", 10}, {"time_step", 0.02}}, film, {});
    materials.push_back(ReadAll(folder_ / "material.json"));
  }
  EXPECT_EQ(materials[0], materials[1]);
}

// A flag of known weight gives the wind and the drag.
TEST_F(StripFitTest, AFlagGivesWindAndDrag) {
  MaterialField reference = Scaled(TestMaterial(), 1.0, 3.0);
  reference.dynamics = {.air_drag = 1.0, .wind = {0.5, 1.0, 3.0}};
  const auto model = MakeModel("strip:0.15x0.03x10", kHeldEdge);
  const nlohmann::json film = Film(*model, reference, Eigen::Vector3d::Zero(),
                                   {.h = 0.02, .steps = 20, .frames = {2, 4, 7, 10, 13, 16, 20}});
  FitStrip("strip:0.15x0.03x10",
           {{"steps", 20}, {"time_step", 0.02}, {"air_drag", 0.7}, {"wind", {0.0, 0.0, 2.5}}}, film,
           {"air_drag", "wind"});
  std::printf("%s, bend %g\n", fitted_.dump().c_str(), Bend());
  const double wind[] = {0.5, 1.0, 3.0};
  for (int d = 0; d < 3; ++d) EXPECT_NEAR(fitted_["wind"]["value"][d], wind[d], 0.1) << fitted_;
  EXPECT_NEAR(Value("air_drag"), 1.0, 0.05);
  EXPECT_NEAR(Bend(), 3.0, 0.3);
}

// A strip that is thrown through air of known drag gives its density and how it was thrown.
TEST_F(StripFitTest, AThrowGivesDensityAndVelocity) {
  MaterialField reference = Scaled(TestMaterial(), 1.0, 2.0);
  reference.density = 0.26;
  reference.dynamics = {.air_drag = 1.0};
  const auto model = MakeModel("strip:0.15x0.03x10", kHeldEdge);
  const nlohmann::json film = Film(*model, reference, {0.0, 0.3, 0.8},
                                   {.h = 0.02, .steps = 20, .frames = {2, 4, 7, 10, 13, 16, 20}});
  FitStrip("strip:0.15x0.03x10",
           {{"steps", 20}, {"time_step", 0.02}, {"air_drag", 1.0}, {"velocity", {0.0, 0.0, 0.5}}},
           film, {"velocity", "density"});
  std::printf("%s, bend %g\n", fitted_.dump().c_str(), Bend());
  const double velocity[] = {0.0, 0.3, 0.8};
  for (int d = 0; d < 3; ++d)
    EXPECT_NEAR(fitted_["velocity"]["value"][d], velocity[d], 0.02) << fitted_;
  EXPECT_NEAR(Value("density"), 0.26, 0.01);
  EXPECT_NEAR(Bend(), 2.0, 0.2);
}

// A cantilever at rest on a coarser mesh: what its clamp carries gives the density, how it vibrates
// the bending stiffness.
TEST_F(StripFitTest, ForceAndFrequencyGiveDensityAndBending) {
  constexpr const char* kClamp =
      R"({"gravity": [0, 0, -9.81],
          "handles": {"region": {"half_plane": {"offset": 0.0061}}, "stiffness": 1e4}})";
  MaterialField reference = Scaled(TestMaterial(), 1.0, 3.0);
  reference.density = 0.26;
  const auto model = MakeModel("strip:0.06x0.02x20", kClamp);
  StepSolver solver(model);
  const EquilibriumResult rest = SolveFromRest(solver, reference, {});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  Eigen::VectorXd found, force;
  ASSERT_TRUE(
      FrequencyReadout(*model, {1, 3}).ReadCloth(reference, rest.x, &found, nullptr, nullptr));
  ASSERT_TRUE(HandleForceReadout(*model, model->held, Eigen::Vector3d::UnitZ())
                  .Read(rest.x, &force, nullptr));
  const nlohmann::json vibration = {{"frequencies", {found[0], found[1]}},
                                    {"modes", {1, 3}},
                                    {"sigma", 0.02 * found[1]}},
                       weight = {
                           {"force", force[0]}, {"along", {0, 0, 1}}, {"sigma", 1e-3 * force[0]}};
  std::printf("frequencies %g %g Hz, force %g N\n", found[0], found[1], force[0]);
  FitStrip("strip:0.06x0.02x10", {}, {vibration, weight}, {"density"});
  std::printf("%s, bend %g\n", fitted_.dump().c_str(), Bend());
  EXPECT_NEAR(Value("density"), 0.26, 0.005);
  EXPECT_NEAR(Bend(), 3.0, 0.45);
}

// Frequencies and shapes are those of all stiffnesses by one density.
TEST_F(StripFitTest, ADensityWithoutAForceIsRefused) {
  MakeModel("strip:0.06x0.02x10", kHeldEdge);
  const nlohmann::json vibration = {{"frequencies", {2.0}}, {"sigma", 0.1}};
  data_.experiment = folder_ / "experiment.json";
  const nlohmann::json strip = {
      {"mesh", "strip:0.06x0.02x10"}, {"scene", "held.json"}, {"measurements", {vibration}}};
  std::ofstream(data_.experiment) << nlohmann::json{{"fit", {"density"}}, {"experiments", {strip}}};
  EXPECT_NE(ComputeError().find("no number in newtons"), std::string::npos) << ComputeError();
}

TEST_F(ExperimentFitTest, WhatDoesNotBelongTogetherIsRefused) {
  WriteExperiments();
  data_.images = {folder_ / "a.png"};
  EXPECT_THROW(RunFitJob(spec_, data_, files_, {}), InputError);
  data_.images.clear();
  spec_.model = FitModel::kBayes;
  EXPECT_THROW(RunFitJob(spec_, data_, files_, {}), InputError);
}

}  // namespace
}  // namespace drape::test
