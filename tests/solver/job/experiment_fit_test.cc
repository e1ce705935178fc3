// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <fstream>
#include <numbers>
#include <random>
#include <span>

#include "losses/readout/observation_files.h"
#include "losses/readout/place_readouts.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/math/random.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/fit_drapes.h"
#include "solver/job/fit_checkpoint.h"
#include "solver/prediction/prediction.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

TEST_F(ExperimentFitTest, MarkersGiveTheStiffnessOfAnotherMesh) {
  WriteExperiments();
  spec_.stages.candidates_per_round = {2};
  spec_.stages.iterations = {8};
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

// The result is that of the finer mesh, and begins with that of the coarser one.
TEST_F(ExperimentFitTest, TheBranchIsSoughtOnACoarserMesh) {
  spec_.stages.candidates_per_round = {1, 1};
  spec_.stages.iterations = {8, 8};
  data_.experiment = folder_ / "experiment.json";
  std::ofstream(data_.experiment)
      << R"({"experiments": [{"name": "square", "mesh": "strip:0.2x0.2x10", "random_starts": 1,)"
      << R"("search_mesh": "strip:0.2x0.2x6", "scene": "corners.json",)"
      << R"("measurements": [{"markers": "markers.csv", "sigma": 5e-4}]}]})";
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json summary = Summary();
  EXPECT_EQ(summary["meshes"]["fits"].size(), 2u) << summary["meshes"];
  EXPECT_FALSE(summary["meshes"]["error"].is_null());
  const MaterialField fitted = ReadMaterial(folder_ / "material.json").field;
  const MaterialField reference = Scaled(TestMaterial(), 0.5, 4.0);
  EXPECT_NEAR(fitted.stretch[0].c[0][0] / reference.stretch[0].c[0][0], 1.0, 0.15);
  EXPECT_NEAR(fitted.bend[0].b[0][0] / reference.bend[0].b[0][0], 1.0, 0.3);
  EXPECT_LT(summary["measurements"][0]["misfit_sigma"], 1.5);
  const Mesh drape = ReadObj(folder_ / "drape_square.obj");
  EXPECT_EQ(drape.num_vertices(), ParseMeshSpec("strip:0.2x0.2x10").num_vertices());
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

// Several branches explain contours and pooled images; markers and further tests tell them apart.
TEST(LeavesBranchOpen, HoldsForContoursAloneAndForPooledImages) {
  const auto seen_by = [](std::vector<bool> are_contours) {
    Experiment experiment;
    for (const bool is_contour : are_contours)
      experiment.measurements.push_back({.name = "seen", .readout = {}, .is_contour = is_contour});
    FitProblem problem;
    problem.observations.emplace_back().experiment =
        std::make_shared<const Experiment>(std::move(experiment));
    return problem;
  };
  EXPECT_TRUE(LeavesBranchOpen(seen_by({true, true})));
  EXPECT_FALSE(LeavesBranchOpen(seen_by({true, false})));
  FitProblem joint = seen_by({true});
  joint.further.resize(1);
  EXPECT_FALSE(LeavesBranchOpen(joint));
  FitProblem image;
  image.observations.resize(1);
  EXPECT_FALSE(LeavesBranchOpen(image));
  image.is_pooled = true;
  EXPECT_TRUE(LeavesBranchOpen(image));
}

// A cloth lies on the support alone or beside further ones; images are no experiment.
TEST(SeesClothOverSupport, LooksAtAllExperiments) {
  const auto in = [](Scene scene) {
    Experiment experiment;
    experiment.scene = std::move(scene);
    return std::make_shared<const Experiment>(std::move(experiment));
  };
  FitProblem problem;
  problem.observations.resize(1);
  EXPECT_FALSE(SeesClothOverSupport(problem));
  problem.observations[0].experiment = in(HangingStripScene(9.8));
  EXPECT_FALSE(SeesClothOverSupport(problem));
  problem.further.resize(1);
  problem.further[0].experiment = in(CusickScene());
  EXPECT_TRUE(SeesClothOverSupport(problem));
  problem.observations[0].experiment.swap(problem.further[0].experiment);
  EXPECT_TRUE(SeesClothOverSupport(problem));
}

// The shipped experiment, made in memory too.
class ExperimentInMemoryTest : public FitJobTest {
 protected:
  static constexpr const char* kFile = DRAPE_SOURCE_DIR "/configs/experiments/square.json";

  ExperimentInMemoryTest() {
    data_ = {};
    data_.experiment = kFile;
    spec_.stages.parameters = ParameterTying::kScales;
    spec_.stages.grid.bend = {1.0};
    spec_.stages.iterations = {4};
  }
  static ExperimentFile Square() {
    const std::string folder = DRAPE_SOURCE_DIR "/configs/experiments/";
    const std::string path = folder + "square_markers.csv";
    const MeasuredMarkers markers = ReadMarkers(path);
    Experiment square{.name = "square",
                      .mesh = ParseMeshSpec("strip:0.2x0.2x20"),
                      .scene = ReadScene(DRAPE_SOURCE_DIR "/configs/scenes/two_corners.json"),
                      .measurements = {{.name = "markers of " + path,
                                        .readout =
                                            [=](const ClothModel& model) {
                                              return std::make_shared<MarkerReadout>(
                                                  WeightsOfMarkers(model.mesh, markers, path));
                                            },
                                        .data = markers.x,
                                        .sigma = 0.002,
                                        .loss = std::make_shared<ceres::HuberLoss>(3.0)}},
                      .search_mesh = ParseMeshSpec("strip:0.2x0.2x10")};
    return {.material = folder + "../fabrics/cotton_blue.json",
            .density = 0.12,
            .experiments = {std::move(square)}};
  }
};

TEST_F(ExperimentInMemoryTest, ItIsTheFitOfTheFile) {
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const std::string memory = folder_ / "memory";
  std::filesystem::create_directory(memory);
  const DrapeFit fit = FitDrapes(spec_, Square(), {}, memory);
  ASSERT_TRUE(fit.fitted());
  EXPECT_EQ(ReadAll(memory + "/material.json"), ReadAll(folder_ / "material.json"));
  EXPECT_EQ(ReadAll(memory + "/drape_square.obj"), ReadAll(folder_ / "drape_square.obj"));
  const nlohmann::json by_file = Summary(), in_memory = ReadJsonFile(memory + "/summary.json");
  for (const char* key : {"parameters", "verdict", "measurements", "initial_guess", "laboratory"})
    EXPECT_EQ(in_memory[key], by_file[key]) << key;
  EXPECT_EQ(by_file["initial_guess"]["material"], Square().material);
}

TEST_F(ExperimentInMemoryTest, WhatCannotBeFittedIsRefused) {
  const auto error = [&](const std::function<void(Experiment&)>& spoil) -> std::string {
    ExperimentFile file = Square();
    spoil(file.experiments[0]);
    try {
      FitDrapes(spec_, file);
    } catch (const InputError& refused) {
      return refused.what();
    }
    return "";
  };
  const auto of_markers = [&](const std::function<void(Measurement&)>& spoil) {
    return error([&](Experiment& each) { spoil(each.measurements[0]); });
  };
  EXPECT_THAT(of_markers([](auto& each) { each.readout = nullptr; }),
              testing::AllOf(testing::StartsWith("experiments in memory: key 'experiments[0]'"),
                             HasSubstr("square_markers.csv: found no readout")));
  EXPECT_THAT(of_markers([](auto& each) { each.data.conservativeResize(3); }),
              HasSubstr("found data of 3 numbers, expected 75"));
  EXPECT_THAT(of_markers([](auto& each) { each.data[0] = NAN; }), HasSubstr("that are finite"));
  EXPECT_THAT(of_markers([](auto& each) { each.sigma = 0.0; }), HasSubstr("found sigma 0"));
  EXPECT_THAT(of_markers([](auto& each) { each.step = 2; }), HasSubstr("found step 2"));
  EXPECT_THAT(error([](auto& each) { each.start.setZero(3); }), HasSubstr("of 3 numbers"));
  EXPECT_THAT(error([](auto& each) { each.mesh = {}; }), HasSubstr("no mesh"));
  EXPECT_THAT(error([](auto& each) { each.name = "../x"; }), HasSubstr("name '../x'"));
  EXPECT_INPUT_ERROR(FitDrapes(spec_, ExperimentFile{}), "at least one experiment");
  EXPECT_THROW(FitDrapes(spec_, Square(), {}, folder_ / "none"), IoError);
  EXPECT_INPUT_ERROR(CheckpointKey(spec_, {}, MakeFitInput(spec_, Square())),
                     "checkpoint: found experiments in memory");
}

// A strip that is clamped horizontally, of three times the bending stiffness of its start tables,
// by eight markers with noise of .5 mm.
class ExperimentPosteriorTest : public StripFitTest {
 protected:
  static constexpr const char* kMesh = "strip:0.15x0.03x10";
  static constexpr const char* kClamp =
      R"({"gravity": [0, 0, -9.81],
          "handles": {"region": {"half_plane": {"offset": 0.0151}}, "stiffness": 1e4}})";

  ExperimentPosteriorTest() : model_(MakeModel(kMesh, kClamp)) {
    spec_.model = FitModel::kBayes;
    spec_.stages.grid.bend = {3.0};
    spec_.stages.prior_sigma = 0.3;
    spec_.posterior.specimen_stretch_sigma = spec_.posterior.specimen_bend_sigma = 0.0;
    spec_.posterior.draws = 16;
    spec_.posterior.rank = 2;
    spec_.posterior.iterations = 10;
    spec_.posterior.elbo_samples = 200;
  }
  Eigen::VectorXd Drape(const MaterialField& material) const {
    const auto backend = MakeCpuBackend(model_, 1);
    const EquilibriumResult rest = SolveFromRest(*backend, material, {});
    EXPECT_EQ(rest.status, EquilibriumStatus::kStable);
    return rest.x;
  }
  static bool IsNear(double weft) { return weft < 0.05; }
  void WriteMarkers() {
    const Eigen::VectorXd x = Drape(reference_);
    std::mt19937_64 random(7);
    std::ofstream file(folder_ / "m.csv");
    file << "vertex,x_m,y_m,z_m\n";
    for (int i = 1; i <= 8; ++i) {
      const int vertex = model_->mesh.num_vertices() * i / 9;
      file << vertex;
      for (int d = 0; d < 3; ++d) file << "," << x[3 * vertex + d] + 5e-4 * SampleNormal(random);
      file << "\n";
    }
  }
  void WriteExperiments(const nlohmann::json& measurement, const nlohmann::json& further = {}) {
    data_.experiment = folder_ / "experiment.json";
    nlohmann::json experiments = {{{"name", "strip"},
                                   {"mesh", kMesh},
                                   {"scene", "held.json"},
                                   {"random_starts", 0},
                                   {"measurements", {measurement}}}};
    if (!further.is_null()) experiments.push_back(further);
    std::ofstream(data_.experiment) << nlohmann::json{{"experiments", experiments}};
  }
  void WriteExperiments(double sigma) {
    WriteMarkers();
    WriteExperiments({{"markers", "m.csv"}, {"sigma", sigma}});
  }
  // Mean and deviation of the logarithm of the rigidity that the strip shows.
  struct Rigidity {
    double mean = 0.0, deviation = 0.0;
  };
  Rigidity Describe(const FabricSamples& samples) const {
    Eigen::ArrayXd logs(samples.tables.size());
    for (Eigen::Index i = 0; i < logs.size(); ++i)
      logs[i] = std::log(EffectiveBend(samples.tables[i], weights_));
    return {logs.mean(), std::sqrt((logs - logs.mean()).square().mean())};
  }
  Rigidity Fitted() {
    const FitJobResult result = RunFitJob(spec_, data_, files_, {});
    EXPECT_TRUE(result.has_posterior) << result.table;
    return Describe(SampleFabric(ReadPosterior(folder_.path()), 1000, 1));
  }

  // The least deviation of a direction of the stored posterior, in units of its prior.
  double Narrowest() const {
    const StoredPosterior stored = ReadPosterior(folder_.path());
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(stored.covariance,
                                                                          stored.FabricPrior());
    return std::sqrt(eigen.eigenvalues()[0]);
  }

  const MaterialField reference_ = Scaled(TestMaterial(), 1.0, 3.0);
  const std::shared_ptr<const ClothModel> model_;
  const Eigen::VectorXd weights_ = StiffnessWeights(*model_, {Drape(reference_)});
};

// The errors of markers are normal, so the Laplace approximation is near; the posterior has the
// reference within three of its deviations, and its samples weigh as they should. Each entry varies
// about the two numbers of the fit.
TEST_F(ExperimentPosteriorTest, MarkersHaveAPosterior) {
  WriteExperiments(5e-4);
  const Rigidity bend = Fitted();
  const nlohmann::json posterior = Summary()["posterior"];
  const StoredPosterior stored = ReadPosterior(folder_.path());
  EXPECT_NEAR(bend.mean, std::log(EffectiveBend(reference_, weights_)), 3.0 * bend.deviation);
  EXPECT_LT(bend.deviation, 0.3 * Describe(SamplePrior(stored, 1000, 1)).deviation);
  EXPECT_LT(Narrowest(), 0.1);
  ASSERT_EQ(stored.num_fabric(), kMaterialEntries);
  EXPECT_EQ(stored.branch_deviation, 0.0);  // the strip has one drape
  double over_laplace = 0.0;                // deviations, in the mean over the entries
  for (const auto& entry : posterior["log_factors"]) {
    over_laplace +=
        entry["sd"].get<double>() / entry["laplace_sd"].get<double>() / kMaterialEntries;
    EXPECT_NEAR(entry["prior_sd"], std::hypot(0.3, 0.5), 1e-9);
  }
  EXPECT_NEAR(over_laplace, 1.0, 0.1);
  EXPECT_GE(posterior["sigma_factor"], 1.0);
  EXPECT_LT(posterior["sigma_factor"], 1.5);
  EXPECT_LT(posterior["pareto_k"], 0.7);
  const StoredSamples samples = ReadSamples(folder_.path(), stored.size());
  ASSERT_EQ(samples.samples.size(), posterior["elbo_samples_valid"]);
  double mean = 0.0;
  for (const StoredSamples::Sample& each : samples.samples)
    mean += (each.log_likelihood + each.log_prior - each.log_density) /
            static_cast<double>(samples.samples.size());
  const double constant =
      24.0 * std::log(posterior["sigma_factor"].get<double>() * std::sqrt(2.0 * std::numbers::pi));
  EXPECT_NEAR(mean - constant, posterior["elbo"].get<double>(), 1e-6);
}

// Errors five times as large as stated widen the posterior, unless σ is not to be estimated.
TEST_F(ExperimentPosteriorTest, WhatIsOffWidensIt) {
  WriteExperiments(1e-4);
  const double wide = Fitted().deviation, widest = Narrowest();
  EXPECT_GT(Summary()["posterior"]["sigma_factor"], 3.0);
  spec_.posterior.estimate_sigma = false;
  EXPECT_LT(Fitted().deviation, 0.75 * wide);  // the form leaves it open
  EXPECT_LT(Narrowest(), 0.5 * widest);
  EXPECT_EQ(Summary()["posterior"]["sigma_factor"], 1.0);
}

// A second cloth of the fabric, and one that moves, count in the posterior too, not in its mode
// alone.
TEST_F(ExperimentPosteriorTest, FurtherExperimentsNarrowIt) {
  spec_.posterior.estimate_sigma = false;
  WriteExperiments(5e-3);
  const double alone = Fitted().deviation;
  const nlohmann::json markers = {{"markers", "m.csv"}, {"sigma", 5e-3}};
  const nlohmann::json again = {
      {"mesh", kMesh}, {"scene", "held.json"}, {"measurements", {markers}}};
  WriteExperiments(markers, again);
  const double prior = Describe(SamplePrior(ReadPosterior(folder_.path()), 1000, 1)).deviation,
               twice = 1.0 / std::sqrt(2.0 / (alone * alone) - 1.0 / (prior * prior));
  EXPECT_NEAR(Fitted().deviation / alone, twice / alone, 0.1);
  const std::string mesh = "strip:0.15x0.03x10";
  nlohmann::json film = Film(*MakeModel(mesh, kClamp), reference_, Eigen::Vector3d::Zero(),
                             {.h = 0.00125, .steps = 160, .frames = {80, 160}});
  for (auto& each : film) each["sigma"] = 1e-3;  // above the errors of mesh and time step
  WriteExperiments(markers, {{"mesh", mesh},
                             {"scene", "held.json"},
                             {"motion", {{"steps", 160}, {"time_step", 0.00125}}},
                             {"measurements", film}});
  EXPECT_LT(Fitted().deviation, 0.7 * alone);
}

// A disc over a support has several drapes, which the posterior counts.
TEST_F(ExperimentPosteriorTest, ADiscBesideTheStripWidensIt) {
  WriteMarkers();
  const nlohmann::json markers = {{"markers", "m.csv"}, {"sigma", 5e-4}};
  WriteExperiments(markers);
  const double alone = Fitted().deviation;
  std::ofstream(folder_ / "hem.csv") << "vertex,x_m,y_m,z_m\n99,0.1,0,-0.05\n";
  WriteExperiments(markers, {{"mesh", "disc:100"},
                             {"scene", DRAPE_SOURCE_DIR "/configs/scenes/cusick.json"},
                             {"measurements", {{{"markers", "hem.csv"}, {"sigma", 0.1}}}}});
  EXPECT_GT(Fitted().deviation, 1.2 * alone);
  EXPECT_EQ(ReadPosterior(folder_.path()).branch_deviation, kModelDeviation);
}

// A strip that bends four times as stiffly near its clamp, by its registered shape.
TEST_F(ExperimentPosteriorTest, FieldsFindTheStifferPart) {
  MaterialField reference = TestMaterial();
  reference.stretch.assign(model_->mesh.num_faces(), reference.stretch[0]);
  reference.bend.assign(model_->mesh.num_hinges(), reference.bend[0]);
  const Eigen::RowVectorXd weft = HingeCentres(model_->mesh).row(0);
  for (int h = 0; h < weft.size(); ++h)
    for (double& entry : std::span(&reference.bend[h].b[0][0], kBendEntries))
      entry *= IsNear(weft[h]) ? 8.0 : 2.0;
  WriteObj(folder_ / "scan.obj", model_->mesh, Drape(reference));
  WriteExperiments({{"shape", "scan.obj"}, {"sigma", 1e-4}});
  spec_.model = FitModel::kHeterogeneous;
  spec_.fields.groups = FieldGroups::kBend;
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const Material fitted = ReadMaterialFor(model_->mesh, folder_ / "material.json");
  double parts[2] = {0.0, 0.0}, counts[2] = {0.0, 0.0};
  for (int h = 0; h < weft.size(); ++h) {
    // Where the strip bends: at edges across it, before it hangs down.
    const Hinge& hinge = model_->mesh.hinges[h];
    const Eigen::Vector2d edge =
        model_->mesh.uv.col(hinge.vertex[1]) - model_->mesh.uv.col(hinge.vertex[0]);
    if (std::abs(edge.y()) < 1e-9 || weft[h] < 0.02 || weft[h] > 0.08) continue;
    const int part = IsNear(weft[h]) ? 1 : 0;
    parts[part] += std::log(MeanBend(fitted.field.bend[h]));
    counts[part] += 1.0;
  }
  const double ratio = std::exp(parts[1] / counts[1] - parts[0] / counts[0]);
  std::printf("near over far: %g\n", ratio);
  EXPECT_GT(ratio, 2.0);
  EXPECT_LT(ratio, 6.0);
  const nlohmann::json summary = Summary();
  EXPECT_LT(summary["measurements"][0]["misfit_sigma"], 3.0) << summary["fields"];
}

TEST_F(ExperimentFitTest, WhatDoesNotBelongTogetherIsRefused) {
  WriteExperiments();
  data_.images = {folder_ / "a.png"};
  EXPECT_THROW(RunFitJob(spec_, data_, files_, {}), InputError);
  data_.images.clear();
  spec_.model = FitModel::kHeterogeneous;
  spec_.fields.basis = FieldBasis::kModes;
  EXPECT_THAT(ComputeError(), HasSubstr("expected elements: modes are of a disc"));
  spec_.fields.basis = FieldBasis::kElements;
  WriteExperiments(
      R"(, {"mesh": "strip:0.2x0.2x10", "scene": "corners.json",
           "measurements": [{"markers": "markers.csv", "sigma": 1}]})");
  EXPECT_THAT(ComputeError(), HasSubstr("model heterogeneous: found further experiments"));
  WriteExperiments();
  spec_.model = FitModel::kBdp;
  EXPECT_THAT(ComputeError(), HasSubstr("fewer than 39 with model bdp"));
}

}  // namespace
}  // namespace drape::test
