// SPDX-License-Identifier: Apache-2.0
// From files to files: what a job reads and writes.
#include "solver/job/fit_job.h"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"
#include "physics/cloth/state.h"
#include "physics/material/material_io.h"
#include "physics/material/material_scaling.h"
#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/statics/statics.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "solver/fit/protocol/initial_guess.h"
#include "solver/posterior/posterior_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/prediction.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape {
namespace {

using test::FitJobTest;
using testing::HasSubstr;

TEST_F(FitJobTest, WritesItsFilesAndRemovesTheCheckpoint) {
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  EXPECT_TRUE(result.fitted);
  EXPECT_FALSE(result.cancelled);
  EXPECT_THAT(result.table, HasSubstr("directions are determined"));
  EXPECT_THAT(result.table, HasSubstr("verdict: "));
  EXPECT_THAT(result.results, testing::ElementsAre("fit_a.png", "material.json"));
  for (const std::string name : {"fit_a.png", "drape_a.obj", "start_a.json", "material.json"})
    EXPECT_TRUE(Exists(name)) << name;
  EXPECT_FALSE(Exists("checkpoint.json"));
  const nlohmann::json summary = Summary();
  EXPECT_EQ(summary["status"], "done");
  EXPECT_EQ(summary["model"], "homogeneous");
  EXPECT_TRUE(summary["notes"].empty());
  EXPECT_EQ(summary["spectrum"]["singular_values"].size(), 39);
  const nlohmann::json& metrics = summary["images"][0]["metrics"];
  EXPECT_LT(metrics["profile_rms_px"].get<double>(), 2.0);
  EXPECT_GT(metrics["iou"].get<double>(), 0.95);
  EXPECT_EQ(summary["mean"]["mse"], metrics["mse"]);
}

// Who watches a fit sees its best outlines while it runs, and no file of them afterwards.
TEST_F(FitJobTest, ShowsItsOutlinesWhileItRuns) {
  files_.outlines = folder_ / "outlines.json";
  std::vector<uint8_t> shown;
  RunControl control;
  control.progress = [&](double, const std::string&) {
    if (Exists("outlines.json")) shown = ReadAll(folder_ / "outlines.json");
  };
  EXPECT_TRUE(RunFitJob(spec_, data_, files_, control).fitted);
  EXPECT_FALSE(Exists("outlines.json"));
  nlohmann::json expected = Summary()["images"][0]["outlines"];
  expected["name"] = "a";
  EXPECT_EQ(nlohmann::json::parse(shown), nlohmann::json::array({expected}));
}

// The bend entries of the table that a job fits to the image of the fixture, moved.
class TurnedFitTest : public FitJobTest {
 protected:
  TurnedFitTest() {
    spec_.stages.iterations = {4};
    spec_.stages.parameters = ParameterTying::kBendRows;
  }
  Eigen::VectorXd Bend(int quarters, bool mirrored, const std::string& warp) {
    data_.images.clear();
    AddImage("b.png", test::QuarterTurned(DrapeImage(), quarters, mirrored));
    spec_.observation.warp = warp;
    EXPECT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
    const MaterialField field = ReadMaterial(folder_ / "material.json").field;
    return Eigen::Map<const Eigen::VectorXd>(field.bend[0].entries(), kBendEntries);
  }
  static double Apart(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a.array() / b.array()).log().abs().maxCoeff();
  }
};

TEST_F(TurnedFitTest, AMirrorImageOrATurnHasTheSameFit) {
  const Eigen::VectorXd bend = Bend(0, false, "up");
  EXPECT_GT(std::abs(std::log(bend[0] / bend[kBendEntries - 1])), 0.02);  // it tells warp and weft
  EXPECT_GT(Apart(Bend(1, false, "up"), bend), 0.02);                     // another cloth
  EXPECT_LT(Apart(Bend(0, true, "up"), bend), 1e-6);
  EXPECT_LT(Apart(Bend(1, false, "right"), bend), 1e-6);
  EXPECT_LT(Apart(Bend(3, true, "right"), bend), 1e-6);
  const nlohmann::json image = Summary()["images"][0];
  EXPECT_LT(image["metrics"]["profile_rms_px"].get<double>(), 2.5);
  EXPECT_EQ(image["warp_degrees"], 0);
}

// The drape is written as the image shows it, with the mesh of that cloth.
TEST_F(TurnedFitTest, WritesTheDrapeAsTheImageShowsIt) {
  for (const bool mirrored : {false, true}) {
    Bend(1, mirrored, "right");
    const nlohmann::json image = Summary()["images"][0];
    const Mesh mesh = ReadObj(folder_ / "drape_b.obj");
    const Observation seen = ReadImageObservation(folder_ / "b.png", spec_.observation);
    const ObjSurface surface = ReadObjSurface(folder_ / "drape_b.obj");
    Outline outline, of_image;
    ASSERT_TRUE(OutlineFromMesh(mesh, surface.x, Camera(), 360, &outline));
    Camera nominal;
    ASSERT_TRUE(OutlineFromImage(seen.image, nominal, 360, &of_image));
    EXPECT_LT(ProfileRms(outline.radius, of_image.radius), 2.5);
    EXPECT_EQ(CountSelfIntersections(mesh, surface.x), 0);
    // Its faces are seen from above, and the plain mesh of the fit is its mirror image or itself.
    const std::array<int, 3>& t = surface.triangles[0];
    const auto p = [&](int k) { return Eigen::Vector3d(surface.x.segment<3>(3 * t[k])); };
    EXPECT_GT((p(1) - p(0)).cross(p(2) - p(0)).z(), 0.0);
    const Mesh plain = test::SmoothDisc(150)->model().mesh;
    EXPECT_EQ(mesh.uv.row(0), plain.uv.row(0));
    EXPECT_EQ(mesh.uv.row(1), (image["cloth_mirrored"] ? -1.0 : 1.0) * plain.uv.row(1));
  }
}

TEST_F(FitJobTest, AnUnknownWarpGivesAStifferAndASofterDirection) {
  spec_.stages.parameters = ParameterTying::kBendRows;
  EXPECT_THAT(RunFitJob(spec_, data_, files_, {}).table,
              testing::AllOf(HasSubstr("edges along warp"), HasSubstr("rigidity B, weft")));
  EXPECT_EQ(Summary()["directions"], (nlohmann::json{"warp", "weft"}));
  EXPECT_TRUE(ReadMaterial(folder_ / "material.json").warp_known);
  spec_.observation.warp = "unknown";
  const std::string table = RunFitJob(spec_, data_, files_, {}).table;
  EXPECT_THAT(table, testing::AllOf(HasSubstr("edges along stiffer"), HasSubstr("B, stiffer"),
                                    HasSubstr("B, softer"), HasSubstr("stiffer over softer")));
  nlohmann::json summary = Summary();
  EXPECT_THAT(summary["notes"].dump(), HasSubstr("the warp is not known (--warp)"));
  EXPECT_TRUE(summary["images"][0]["warp_degrees"].is_null());
  EXPECT_FALSE(ReadMaterial(folder_ / "material.json").warp_known);
  summary.erase("notes");
  summary["images"][0].erase("warp_degrees");
  EXPECT_THAT(summary.dump() + table,
              testing::Not(testing::AnyOf(HasSubstr("warp"), HasSubstr("weft"))));
  for (const nlohmann::json& row : summary["laboratory"]["material"]["rows"])
    EXPECT_TRUE(row["key"] != "bending_ratio" || row["value"] >= 1.0);
}

TEST_F(FitJobTest, TheWarpIsKnownInAllImagesOrInNone) {
  nlohmann::ordered_json camera = CameraJson(Camera());
  spec_.observation.camera.file = "beside";
  spec_.observation.warp = "unknown";
  for (const char* name : {"one", "two"}) {
    AddImage(std::string(name) + "/" + name + ".png", DrapeImage());
    WriteFileAtomically(folder_ / name + "/camera.json", camera.dump());
    camera["warp"] = "right";
  }
  data_.images.erase(data_.images.begin());
  EXPECT_THAT(ComputeError(), HasSubstr("two.png: the warp is known, expected as in"));
  WriteFileAtomically(folder_ / "one/camera.json", camera.dump());
  EXPECT_EQ(ComputeError(), "");
  EXPECT_EQ(Summary()["images"][0]["warp_degrees"], 0);
}

TEST_F(FitJobTest, HeterWritesFieldsThatBelongToTheDrape) {
  spec_.model = FitModel::kHeterogeneous;
  spec_.fields.iterations = 3;
  spec_.fields.restarts = 0;
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  EXPECT_THAT(result.table, HasSubstr("over the cloth"));
  EXPECT_TRUE(Exists("material_homogeneous.json"));
  const auto backend = test::SmoothDisc(150);
  const ClothModel& model = backend->model();
  const Material material = ReadMaterialFor(model.mesh, folder_ / "material.json");
  EXPECT_EQ(material.field.bend.size(), static_cast<size_t>(model.mesh.num_hinges()));
  const State start = ReadState(folder_ / "start_a.json", model.mesh.num_vertices());
  EXPECT_LT(ForceResidual(model, material.field, start.x), 1e-8);
  const nlohmann::json fields = ReadJsonFile(folder_ / "fields.json");
  for (const char* of : {"stretch_n_per_m", "stretch_uncertainty", "faces"})
    EXPECT_EQ(fields.at(of).size(), static_cast<size_t>(model.mesh.num_faces())) << of;
  for (const char* of : {"bend_n_m", "bend_uncertainty", "hinges"})
    EXPECT_EQ(fields.at(of).size(), static_cast<size_t>(model.mesh.num_hinges())) << of;
  EXPECT_EQ(fields.at("uv_m").size(), static_cast<size_t>(model.mesh.num_vertices()));
  EXPECT_EQ(fields.at("bend_n_m")[7], MeanBend(material.field.bend[7]));
  const nlohmann::json summary = Summary();
  EXPECT_EQ(summary["model"], "heterogeneous");
  EXPECT_EQ(summary["fields"]["parameters"], 39 + model.mesh.num_faces() + model.mesh.num_hinges());
  EXPECT_LE(summary["fields"]["cost"], summary["fields"]["initial_cost"]);
  EXPECT_LE(summary["fields"]["bend_uncertainty"]["mean_of_posterior_over_prior_sd"], 1.0);
}

TEST_F(FitJobTest, BayesSaysHowSureItIs) {
  spec_.model = FitModel::kBayes;
  spec_.stages.parameters = ParameterTying::kScales;
  spec_.stages.prior_sigma = 0.3;
  spec_.posterior.draws = 8;
  spec_.posterior.rank = 2;
  spec_.posterior.iterations = 8;
  spec_.posterior.elbo_samples = 25;
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  EXPECT_THAT(result.table, HasSubstr("evidence lower bound"));
  for (const std::string name : {"material_homogeneous.json", "base.json", "posterior.json"})
    EXPECT_TRUE(Exists(name)) << name;
  const nlohmann::json posterior = Summary()["posterior"];
  ASSERT_EQ(posterior["log_factors"].size(), 4);  // two scales, and those of one specimen
  const nlohmann::json& bend = posterior["log_factors"][1];
  EXPECT_EQ(bend["name"], "bend");
  EXPECT_LT(bend["sd"], bend["prior_sd"]);
  EXPECT_GT(bend["sd"], 0.0);
  EXPECT_GT(posterior["elbo_samples_valid"], 20);
  EXPECT_GT(posterior["sigma_px"], 0.0);
  const nlohmann::json file = ReadJsonFile(folder_ / "posterior.json");
  EXPECT_EQ(file["covariance"].size(), 4);
}

// The samples that the posterior is judged by, with the outlines of their drapes, although the
// specimens are not in the order of the images.
TEST_F(FitJobTest, BayesKeepsTheOutlinesOfItsSamples) {
  AddImage("b.png", TurnedImage(DrapeImage(), Camera(), 0.4, false));
  data_.specimens = {2, 1};
  spec_.model = FitModel::kBayes;
  spec_.stages.parameters = ParameterTying::kScales;
  spec_.stages.prior_sigma = 0.3;
  spec_.posterior.draws = 4;
  spec_.posterior.rank = 0;
  spec_.posterior.iterations = 3;
  spec_.posterior.elbo_samples = 25;
  RunFitJob(spec_, data_, files_, {});
  const nlohmann::json summary = Summary(), posterior = summary["posterior"];
  const StoredPosterior stored = ReadPosterior(folder_.path());
  const StoredSamples samples = ReadSamples(folder_.path(), stored.size());
  EXPECT_EQ(samples.drawn, 25);
  ASSERT_EQ(samples.samples.size(), posterior["elbo_samples_valid"]);
  ASSERT_EQ(samples.images.size(), 2u);
  EXPECT_EQ(samples.images[0].name, "a");
  EXPECT_EQ(samples.images[1].name, "b");
  const double metre = Camera().scale;
  EXPECT_NEAR(samples.images[0].sigma * metre, posterior["sigma_px"].get<double>(), 1e-12);
  // Drapes of the first sample, from where the fit's own are.
  const auto backend = test::SmoothDisc(150);
  for (int i = 0; i < 2; ++i) {
    const StoredSamples::Sample& sample = samples.samples[0];
    const Eigen::VectorXd specimen = sample.log_factors.segment(2 + 2 * (1 - i), 2).array().exp();
    const MaterialField material = Scaled(
        TableParametrisation(stored.base, stored.fabric).Material(sample.log_factors.head(2)),
        specimen[0], specimen[1]);
    const State start = ReadState(folder_ / ("start_" + samples.images[i].name + ".json"),
                                  backend->model().mesh.num_vertices());
    const State drape = test::Settled(*backend, material, start);
    Outline outline;
    ASSERT_TRUE(
        OutlineFromMesh(backend->model().mesh, drape.x, Camera(), samples.angles(), &outline));
    EXPECT_LT((outline.radius / metre - sample.radius.col(i)).cwiseAbs().maxCoeff(), 1e-4) << i;
  }
  // What the summary says of them.
  Eigen::VectorXd weights(samples.samples.size());
  double squares = 0.0;
  for (Eigen::Index s = 0; s < weights.size(); ++s) {
    const StoredSamples::Sample& sample = samples.samples[s];
    weights[s] = samples.LogLikelihood(sample).sum() + sample.log_prior - sample.log_density;
    for (int i = 0; i < 2; ++i)
      squares += (sample.radius.col(i) - samples.images[i].radius).squaredNorm();
  }
  const double radii = 2.0 * samples.angles();
  EXPECT_NEAR(metre * std::sqrt(squares / radii / static_cast<double>(weights.size())),
              posterior["sample_rms_px"].get<double>(), 1e-9);
  EXPECT_NEAR(weights.mean() - radii * std::log(metre), posterior["elbo"].get<double>(), 1e-6);
  EXPECT_NEAR(ParetoShape(weights), posterior["pareto_k"].get<double>(), 1e-6);
}

// Two at once, of two priors, have the bits that each has alone.
TEST_F(FitJobTest, FitsThatShareBackendsAreTheirOwn) {
  const auto fit = [this](int i, SharedBackends* all) {
    FitSpec spec = spec_;
    spec.stages.prior_sigma = 0.5 * (i + 1);
    FitFiles files = files_;
    files.out = folder_ / std::to_string(i);
    files.checkpoint = files.out + ".json";
    files.log = files.out + ".log";
    std::filesystem::create_directories(files.out);
    std::optional<SharedBackends::Member> member;
    FitData data = data_;
    if (all != nullptr) data.shared = &member.emplace(*all);
    EXPECT_TRUE(RunFitJob(spec, data, files, {}).fitted);
    return ReadJsonFile(files.out + "/material.json").at("stretch");
  };
  const nlohmann::json alone[] = {fit(0, nullptr), fit(1, nullptr)};
  ASSERT_NE(alone[0], alone[1]);
  SharedBackends shared;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 2; ++i)
    threads.emplace_back([&, i] { EXPECT_EQ(fit(i, &shared), alone[i]); });
}

// One drape under two names says no more than under one.
TEST_F(FitJobTest, RepeatedPicturesCountOnce) {
  spec_.model = FitModel::kBayes;
  spec_.stages.parameters = ParameterTying::kScales;
  spec_.posterior.draws = 4;
  spec_.posterior.iterations = 2;
  spec_.posterior.elbo_samples = 25;
  RunFitJob(spec_, data_, files_, {});
  const nlohmann::json one = Summary();
  AddImage("b.png", DrapeImage());
  RunFitJob(spec_, data_, files_, {});
  EXPECT_EQ(Summary()["laboratory"]["material"], one["laboratory"]["material"]);
  EXPECT_THAT(Summary()["notes"].dump(), HasSubstr("b: the same outline as a: it counts once"));
}

// Density and stiffness in proportion leave the drape, and so all lengths, as they are.
TEST_F(FitJobTest, DensityAndStiffnessInProportionAreOneDrape) {
  RunFitJob(spec_, data_, files_, {});
  const LaboratorySheet light = ReadSheet(folder_.path(), "material").value();
  WriteStart(Scaled(test::TestMaterial(), 2.0, 2.0));
  data_.density *= 2.0;
  RunFitJob(spec_, data_, files_, {});
  const LaboratorySheet heavy = ReadSheet(folder_.path(), "material").value();
  for (const auto& [key, ratio] :
       {std::pair("bending_length_overall_cm", 1.0), std::pair("bending_overall_un_m", 2.0),
        std::pair("bending_in_drape_un_m", 2.0)}) {
    EXPECT_NEAR(heavy.of(key).value / light.of(key).value, ratio, 0.01 * ratio) << key;
    EXPECT_EQ(heavy.of(key).source, light.of(key).source) << key;
  }
}

TEST_F(FitJobTest, BdpSaysHowElementsScatter) {
  AddImage("b.png", DrapeImage());  // another specimen
  data_.specimens = {1, 2};
  UseBdp();
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  EXPECT_THAT(result.table, HasSubstr("faces and hinges, mean and standard deviation"));
  const nlohmann::json posterior = Summary()["posterior"];
  EXPECT_EQ(posterior["kind"], "bdp");
  EXPECT_EQ(posterior["specimens"], 2);
  ASSERT_EQ(posterior["log_factors"].size(), 39);
  EXPECT_GT(posterior["elbo_samples_valid"], 20);
  EXPECT_LT(posterior["sample_rms_px"], 3.0);
  EXPECT_GT(posterior["stretch_n_per_m"][1], 0.0);
  const auto backend = test::SmoothDisc(150);
  const FabricSource fabric = ReadFabric(folder_.path());
  EXPECT_EQ(fabric.kind, "bdp");
  const MaterialSource materials = MakeSpecimens(fabric, backend->model().mesh, 1);
  const StoredPosterior stored = ReadPosterior(folder_.path());
  EXPECT_EQ(stored.element_sd[7], posterior["log_factors"][7]["element_sd"]);
  // Elements scatter by what was learned: the mean of squares over all faces of one entry.
  const MaterialField drawn = materials(0);
  const MaterialField median = ReadMaterial(folder_ / "material.json").field;
  double square = 0.0;
  for (const StretchTable& table : drawn.stretch)
    square += std::pow(std::log(table.c[1][3] / median.stretch[0].c[1][3]), 2);
  EXPECT_NEAR(std::sqrt(square / drawn.stretch.size()), stored.element_sd[7],
              0.2 * stored.element_sd[7]);
}

TEST_F(FitJobTest, BdpNeedsAllEntries) {
  UseBdp();
  spec_.stages.parameters = ParameterTying::kColumns;
  EXPECT_THAT(ComputeError(), HasSubstr("parameters: fewer than 39 with model bdp, expected 39"));
}

// The posterior starts again, from the candidate of the checkpoint.
TEST_F(FitJobTest, PosteriorsGoOnAfterACancelToTheSameFiles) {
  UseBdp();
  for (const FitModel model : {FitModel::kBdp, FitModel::kBayes}) {
    spec_.model = model;
    files_.resume = false;
    RunFitJob(spec_, data_, files_, {});
    const auto whole = ReadAll(folder_ / "posterior.json");
    const auto table = ReadAll(folder_ / "material.json");
    nlohmann::json numbers = Summary()["posterior"];
    numbers.erase("seconds");
    std::filesystem::remove(folder_ / "posterior.json");
    std::atomic<bool> cancel = false;
    const RunControl control{
        &cancel, [&](double, const std::string& note) { cancel = cancel || note == "posterior"; }};
    EXPECT_TRUE(RunFitJob(spec_, data_, files_, control).cancelled);
    EXPECT_TRUE(Exists("checkpoint.json"));
    EXPECT_FALSE(Exists("posterior.json"));
    files_.resume = true;
    std::vector<std::string> lines;
    RunControl listening;
    listening.log = [&](const std::string& line) { lines.push_back(line); };
    const FitJobResult resumed = RunFitJob(spec_, data_, files_, listening);
    EXPECT_FALSE(resumed.cancelled);
    EXPECT_THAT(lines, testing::Contains(HasSubstr("the posterior starts again")));
    EXPECT_EQ(ReadAll(folder_ / "posterior.json"), whole);
    EXPECT_EQ(ReadAll(folder_ / "material.json"), table);
    nlohmann::json again = Summary()["posterior"];
    again.erase("seconds");
    EXPECT_EQ(again, numbers);
  }
}

TEST_F(FitJobTest, SpecimensAreOneNumberForEachImage) {
  spec_.model = FitModel::kBayes;
  data_.specimens = {1, 1};
  EXPECT_THAT(ComputeError(), HasSubstr("specimens"));
  data_.specimens = {2};
  EXPECT_THAT(ComputeError(), HasSubstr("from 1"));
}

TEST_F(FitJobTest, HeterNeedsImagesAndRest) {
  spec_.model = FitModel::kHeterogeneous;
  spec_.stages.residuals.solve_mode = SolveMode::kDynamic;
  EXPECT_THAT(ComputeError(), HasSubstr("dynamic"));
  spec_.stages.residuals.solve_mode = SolveMode::kStatic;
  data_.images.clear();
  data_.lab_measurements = {"some.json"};
  EXPECT_THAT(ComputeError(), HasSubstr("heterogeneous without images"));
}

// The stored drape is an equilibrium of the stored material.
TEST_F(FitJobTest, TheFilesBelongTogether) {
  RunFitJob(spec_, data_, files_, {});
  const auto backend = test::SmoothDisc(150);
  const MaterialField material = ReadMaterial(folder_ / "material.json").field;
  const State start =
      ReadStart(folder_ / "start_a.json", backend->model().mesh, DrapeDiscs().support);
  EXPECT_LT(ForceResidual(backend->model(), material, start.x), 1e-8);
}

// As drape_fit does by default.
TEST_F(FitJobTest, MoreNumbersStartFromTheFitsByFewer) {
  spec_.simpler_models = true;
  double last = std::numeric_limits<double>::infinity();
  for (const auto& [form, parameters] : {std::pair(TableForm::kIsotropic, ParameterTying::kScales),
                                         std::pair(TableForm::kLinear, ParameterTying::kColumns),
                                         std::pair(TableForm::kGiven, ParameterTying::kEntries)}) {
    spec_.table_form = form;
    spec_.stages.parameters = parameters;
    ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
    const nlohmann::json summary = Summary();
    EXPECT_LE(summary["cost"].get<double>(), last) << ToString(form);
    last = summary["cost"].get<double>();
  }
  EXPECT_EQ(Summary()["simpler_models"]["fits"].size(), 3u);
}

// A fit that is found on a coarser mesh has an estimate of its mesh error; one on a single mesh
// none.
TEST_F(FitJobTest, AFitOnSeveralMeshesTellsItsMeshError) {
  spec_.mesh = "disc:300";
  spec_.search_mesh = "disc:150";
  spec_.stages.parameters = ParameterTying::kScales;
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
  const nlohmann::json meshes = Summary()["meshes"];
  ASSERT_EQ(meshes["fits"].size(), 2u);
  const nlohmann::json &coarse = meshes["fits"][0], &fine = meshes["fits"][1];
  const double growth = fine["vertices"].get<double>() / coarse["vertices"].get<double>();
  EXPECT_GT(growth, 1.8);
  EXPECT_NEAR(meshes["error"]["log_bend"].get<double>() * (growth - 1.0),
              std::log(fine["bend_n_m"].get<double>() / coarse["bend_n_m"].get<double>()), 1e-9);
  spec_.search_mesh = "disc:300";
  RunFitJob(spec_, data_, files_, {});
  EXPECT_EQ(Summary()["meshes"]["fits"].size(), 1u);
  EXPECT_TRUE(Summary()["meshes"]["error"].is_null());
}

// D/(ρg) and its cube root do not change with the density that is assumed.
TEST_F(FitJobTest, SaysWhenTheDensityIsThatOfTheStartTables) {
  data_.density = 0.0;
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  EXPECT_THAT(result.table, HasSubstr("Trust bending length c, overall "));
  EXPECT_THAT(result.table, HasSubstr(" measured, if the assumed mass is right"));
  nlohmann::json summary = Summary();
  EXPECT_THAT(summary["notes"].dump(), HasSubstr("0.2 kg/m2, is that of the start tables"));
  EXPECT_EQ(summary["bending"]["density_from"], "start tables");
  const double rigidity = summary["stiffness"]["bend_n_m"]["fitted"];
  const double over_weight = summary["bending"]["bend_over_weight_m3"];
  EXPECT_NEAR(over_weight, rigidity / (0.2 * 9.80665), 1e-12 * over_weight);
  EXPECT_NEAR(std::pow(summary["bending"]["bending_length_m"].get<double>(), 3), over_weight,
              1e-9 * over_weight);
  data_.density = 0.2;
  RunFitJob(spec_, data_, files_, {});
  EXPECT_EQ(Summary()["bending"]["density_from"], "given");
  EXPECT_TRUE(Summary()["notes"].empty());
}

TEST_F(FitJobTest, StartEntriesThatALogScaleCannotMoveAreRaisedAndNoted) {
  spec_.min_relative_stiffness = 0.1;
  MaterialField start = test::TestMaterial();
  start.stretch[0].c[2][1] = 0.0;
  start.bend[0].b[1][0] = 0.0;
  WriteStart(start);
  spec_.stages.prior_sigma = 1e-6;
  RunFitJob(spec_, data_, files_, {});
  EXPECT_THAT(Summary()["notes"].dump(),
              HasSubstr("2 entries of " + data_.material + " were raised to 0.1"));
  const MaterialField fitted = ReadMaterial(folder_ / "material.json").field;
  EXPECT_NEAR(fitted.stretch[0].c[2][1], 0.1 * start.stretch[0].c[5][1], 1e-4);
  EXPECT_NEAR(fitted.bend[0].b[1][0], 4.0 * 0.1 * start.bend[0].b[1][4], 1e-9);
}

TEST_F(FitJobTest, GoesOnAfterACancelToTheSameFiles) {
  RunFitJob(spec_, data_, files_, {});
  const auto whole = ReadAll(folder_ / "material.json");
  std::atomic<bool> cancel = false;
  const RunControl control = CancelInRoundOne(&cancel);
  EXPECT_TRUE(RunFitJob(spec_, data_, files_, control).cancelled);
  EXPECT_TRUE(Exists("checkpoint.json"));
  EXPECT_EQ(Summary()["status"], "cancelled");
  files_.resume = true;
  EXPECT_FALSE(RunFitJob(spec_, data_, files_, {}).cancelled);
  EXPECT_EQ(ReadAll(folder_ / "material.json"), whole);
}

TEST_F(FitJobTest, AChangedSettingRefusesTheCheckpoint) {
  std::atomic<bool> cancel = false;
  RunFitJob(spec_, data_, files_, CancelInRoundOne(&cancel));
  files_.resume = true;
  spec_.stages.residuals.sigma_px = 0.7;
  EXPECT_THAT(ComputeError(), HasSubstr("found another 'sigma_px'"));
}

TEST_F(FitJobTest, TheSolveModeIsPartOfTheKey) {
  std::atomic<bool> cancel = false;
  RunFitJob(spec_, data_, files_, CancelInRoundOne(&cancel));
  files_.resume = true;
  spec_.stages.residuals.solve_mode = SolveMode::kDynamic;
  EXPECT_THAT(ComputeError(), HasSubstr("run without --resume"));
}

// What a job of a fit refuses, and how it says so.

TEST_F(FitJobTest, TwoImagesOfOneNameAreRefused) {
  AddImage("other/a.png", DrapeImage());
  EXPECT_THAT(ComputeError(),
              testing::AllOf(HasSubstr("other/a.png"), HasSubstr("distinct names")));
}

TEST_F(FitJobTest, BadImagesAreNamed) {
  GrayImage border = DrapeImage();
  for (int row = 100; row < 140; ++row)
    for (int column = 0; column < 128; ++column) border.at(column, row) = 1.0f;
  AddImage("one_pixel.png", GrayImage(1, 1, 1.0f));
  AddImage("white.png", GrayImage(256, 256));
  AddImage("border.png", border);
  AddImage("corner.png", [] {
    GrayImage image(256, 256);
    for (int i = 5; i < 25; ++i)
      for (int j = 5; j < 25; ++j) image.at(i, j) = 1.0f;
    return image;
  }());
  WriteAll(folder_ / "empty.png", {});
  for (const std::string name : {"empty", "one_pixel", "white", "border", "corner", "absent"}) {
    data_.images = {folder_ / (name + ".png")};
    EXPECT_THAT(ComputeError(), HasSubstr(name + ".png")) << name;
  }
  EXPECT_FALSE(Exists("summary.json"));
}

TEST_F(FitJobTest, BadSettingsAreNamed) {
  data_.images.clear();
  EXPECT_THAT(ComputeError(), HasSubstr("images: found no silhouette"));
  AddImage("a.png", DrapeImage());
  MaterialField negative = test::TestMaterial();
  negative.stretch[0].c[0][1] = -1.0;
  WriteStart(negative);
  EXPECT_THAT(ComputeError(), HasSubstr("start.json"));
}

TEST(ParseName, KnowsTheNamesOfAnEnum) {
  EXPECT_EQ(ParseName<CentreMode>("nominal", "centre"), CentreMode::kNominal);
  EXPECT_EQ(ParseName<FitModel>(ToString(FitModel::kBdp), "model"), FitModel::kBdp);
  EXPECT_INPUT_ERROR(ParseName<CentreMode>("Outline", "centre"),
                     "centre: found 'Outline', expected one of nominal, outline");
}

}  // namespace
}  // namespace drape
