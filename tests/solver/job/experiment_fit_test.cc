// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iomanip>
#include <random>

#include "losses/readout/place_readouts.h"
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

// A strip that swings down, seen in six frames, gives damping and drag beside its stiffness.
TEST_F(ExperimentFitTest, AMotionGivesDampingAndDrag) {
  std::ofstream(folder_ / "held.json")
      << R"({"gravity": [0, 0, -9.81], "handles": {"region": {"half_plane": {"offset": 0.001}}, "stiffness": 1e3}})";
  const auto model = std::make_shared<const ClothModel>(
      ParseMeshSpec("strip:0.15x0.03x10"), ReadScene(folder_ / "held.json"), MakeLaw("smooth"));
  MaterialField reference = Scaled(TestMaterial(), 1.0, 3.0);
  reference.dynamics = {.mass_damping = 2.0, .air_drag = 1.0};
  const State flat = model->RestState();
  const RolloutInput input{&reference, &flat};
  RolloutOptions steps{.h = 0.02, .steps = 30, .frames = {5, 10, 15, 20, 25, 30}};
  const RolloutResult seen =
      MakeCpuBackend(model, 1)->Rollouts({&input, 1}, steps, nullptr).front();
  ASSERT_EQ(seen.status, RolloutStatus::kOk);
  nlohmann::json measurements;
  for (std::size_t k = 0; k < steps.frames.size(); ++k) {
    const std::string name = "frame" + std::to_string(k) + ".csv";
    std::ofstream file(folder_ / name);
    file << "vertex,x_m,y_m,z_m\n" << std::setprecision(17);
    for (int i = 0; i < model->mesh.num_vertices(); i += 5)
      file << i << "," << seen.frames[k].x[3 * i] << "," << seen.frames[k].x[3 * i + 1] << ","
           << seen.frames[k].x[3 * i + 2] << "\n";
    measurements.push_back({{"markers", name}, {"sigma", 1e-4}, {"step", steps.frames[k]}});
  }
  data_.experiment = folder_ / "experiment.json";
  const nlohmann::json motion = {
      {"steps", 30}, {"time_step", 0.02}, {"mass_damping", 1.0}, {"air_drag", 0.3}};
  const nlohmann::json swing = {{"name", "swing"},
                                {"mesh", "strip:0.15x0.03x10"},
                                {"scene", "held.json"},
                                {"motion", motion},
                                {"measurements", measurements}};
  std::ofstream(data_.experiment) << nlohmann::json{{"fit", {"mass_damping", "air_drag"}},
                                                    {"experiments", {swing}}};
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json summary = Summary();
  EXPECT_NEAR(summary["dynamics"]["mass_damping"]["value"], 2.0, 0.1) << summary["dynamics"];
  EXPECT_NEAR(summary["dynamics"]["air_drag"]["value"], 1.0, 0.1);
  const double bend = ReadMaterial(folder_ / "material.json").field.bend[0].b[0][0] /
                      TestMaterial().bend[0].b[0][0];
  EXPECT_NEAR(bend, 3.0, 0.3);
  for (const nlohmann::json& each : summary["measurements"]) EXPECT_LT(each["misfit_sigma"], 1.0);
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
