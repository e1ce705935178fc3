// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "losses/readout/place_readouts.h"
#include "physics/material/material_io.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "solver/job/fit_job.h"
#include "tests/losses/temp_folder.h"
#include "tests/solver/solver_fixture.h"

namespace drape::test {

// A job of one image, made with four times the bending stiffness of its start tables.
class FitJobTest : public testing::Test {
 protected:
  FitJobTest() {
    WriteStart(TestMaterial());
    data_.material = folder_ / "start.json";
    data_.density = TestMaterial().density;
    spec_.simpler_models = false;
    spec_.mesh = "disc:150";
    spec_.coarse_mesh = "disc:100";
    files_.out = folder_.path();
    files_.checkpoint = folder_ / "checkpoint.json";
    files_.log = folder_ / "fit.log";
    spec_.stages.grid.stretch = {1.0};
    spec_.stages.grid.bend = {4.0};
    spec_.stages.grid.lifts = {1.0};
    spec_.stages.candidates_per_round = {1};
    spec_.stages.iterations = {2};
    spec_.observation.angles = 72;
    spec_.observation.warp = "up";
    AddImage("a.png", DrapeImage());
  }
  void WriteStart(const MaterialField& field) const {
    WriteMaterial(folder_ / "start.json", {.name = "start",
                                           .field = field,
                                           .source_convention = "arcsim",
                                           .source = "",
                                           .warnings = {}});
  }
  static const GrayImage& DrapeImage() {
    static const GrayImage image = [] {
      const auto backend = SmoothDisc(150);
      const MaterialField reference = Scaled(TestMaterial(), 1.0, 4.0);
      const State drape = Settled(*backend, reference, RandomStart(backend->model(), 1));
      return MakeObservation(backend->model().mesh, drape, 72, "reference").image;
    }();
    return image;
  }
  void AddImage(const std::string& name, const GrayImage& image) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    WritePng(image, folder_ / name);
    data_.images.push_back(folder_ / name);
  }
  void UseBdp() {
    spec_.model = FitModel::kBdp;
    spec_.stages.prior_sigma = 0.3;
    spec_.posterior.draws = 2;
    spec_.posterior.iterations = 3;
    spec_.posterior.elbo_samples = 25;
  }
  static RunControl CancelInRoundOne(std::atomic<bool>* cancel) {
    return {cancel, [cancel](double, const std::string& note) {
              if (note.starts_with("round 1")) *cancel = true;
            }};
  }
  std::string ComputeError() const {
    try {
      RunFitJob(spec_, data_, files_, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  nlohmann::json Summary() const { return ReadJsonFile(folder_ / "summary.json"); }
  bool Exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  const TempFolder folder_;
  FitSpec spec_;
  FitData data_;
  FitFiles files_;
};

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
  // Measures a cloth of four times the bending stiffness and half the stretching stiffness.
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
  // every frame, as a fit by so many time steps for each reads them.
  nlohmann::json Film(const ClothModel& model, const MaterialField& reference,
                      const Eigen::Vector3d& velocity, const RolloutOptions& steps, int finer = 1) {
    State start = model.RestState();
    start.v = velocity.replicate(model.mesh.num_vertices(), 1);
    const RolloutInput input{&reference, &start};
    const auto backend = MakeCpuBackend(std::make_shared<const ClothModel>(model), 1);
    const auto roll = [&](int parts) {
      RolloutResult rolled =
          backend->Rollouts({&input, 1}, WithFinerSteps(steps, parts), nullptr).front();
      EXPECT_EQ(rolled.status, RolloutStatus::kOk);
      return rolled.frames;
    };
    const std::vector<State> seen = roll(2 * finer), coarser = roll(finer);
    Eigen::Matrix2Xd places(2, 8);
    for (int i = 0; i < 8; ++i) places.col(i) << 0.035 * (1 + i / 2), i % 2 == 0 ? -0.01 : 0.01;
    const MarkerReadout markers(WeightsOfPlaces(model.mesh, places, ""));
    nlohmann::json measurements;
    for (std::size_t k = 0; k < steps.frames.size(); ++k) {
      const std::string name = "frame" + std::to_string(k) + ".csv";
      Eigen::VectorXd x;
      EXPECT_TRUE(markers.Read(2.0 * seen[k].x - coarser[k].x, &x, nullptr));
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
  void StartFit(const std::string& mesh, const nlohmann::json& motion,
                const nlohmann::json& measurements, const std::vector<std::string>& fit) {
    data_.experiment = folder_ / "experiment.json";
    nlohmann::json strip = {
        {"name", "strip"}, {"mesh", mesh}, {"scene", "held.json"}, {"measurements", measurements}};
    if (!motion.empty()) strip["motion"] = motion;
    std::ofstream(data_.experiment) << nlohmann::json{{"fit", fit}, {"experiments", {strip}}};
    ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  }
  // One that explains all measurements.
  void FitStrip(const std::string& mesh, const nlohmann::json& motion,
                const nlohmann::json& measurements, const std::vector<std::string>& fit) {
    StartFit(mesh, motion, measurements, fit);
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

}  // namespace drape::test
