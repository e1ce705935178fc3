// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
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
  const MaterialField truth = Scaled(TestMaterial(), 0.5, 4.0);
  EXPECT_NEAR(fitted.stretch[0].c[0][0] / truth.stretch[0].c[0][0], 1.0, 0.15);
  EXPECT_NEAR(fitted.bend[0].b[0][0] / truth.bend[0].b[0][0], 1.0, 0.3);
  EXPECT_LT(summary["measurements"][0]["misfit_sigma"], 1.5);
  EXPECT_EQ(summary["measurements"][0]["numbers"], 75);
  EXPECT_TRUE(std::filesystem::exists(std::string(folder_ / "drape_square.obj")));
  EXPECT_NE(result.table.find("markers of"), std::string::npos);
}

// A second cloth of the fabric, whose reading contradicts none of the markers.
TEST_F(ExperimentFitTest, TwoExperimentsAreOneFit) {
  WriteExperiments(
      R"(, {"name": "strip", "mesh": "strip:0.06x0.02x12",
           "scene": {"gravity": [0, 0, -9.81], "handles": {"region": {"half_plane": {"offset": 0.006}}}},
           "measurements": [{"angle": 30, "tip": [12], "clamp": [0.005, 0, 0], "along": [1, 0, 0],
                             "sigma": 5}]})");
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json measurements = Summary()["measurements"];
  ASSERT_EQ(measurements.size(), 2u);
  EXPECT_EQ(measurements[1]["experiment"], "strip");
  EXPECT_EQ(measurements[1]["numbers"], 1);
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
