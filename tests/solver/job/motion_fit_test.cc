// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>

#include "losses/readout/scene_readouts.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape::test {
namespace {

using testing::HasSubstr;

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

// Both end in valleys with a tenth of the bending stiffness from the start tables alone.
TEST_F(StripFitTest, AMotionIsFittedFromSeveralScales) {
  spec_.stages.parameters = ParameterTying::kScales;
  const std::string mesh = "strip:0.2x0.2x8";
  const auto model = MakeModel(mesh, kCorners);
  for (const auto& [stretch, bend] : {std::pair{1.0, 10.0}, {3.0, 3.0}}) {
    const nlohmann::json film =
        Film(*model, Scaled(TestMaterial(), stretch, bend), Eigen::Vector3d::Zero(),
             {.h = 0.02, .steps = 20, .frames = {4, 8, 12, 16, 20}});
    FitStrip(mesh, {{"steps", 20}, {"time_step", 0.02}}, film, {});
    EXPECT_NEAR(Bend() / bend, 1.0, 0.01) << stretch;
  }
}

// A mesh that is too coarse for a motion says so, and intervals contain its error.
TEST_F(StripFitTest, IntervalsOfAMotionContainTheErrorOfItsMesh) {
  spec_.stages.parameters = ParameterTying::kScales;
  const auto fabric = MakeModel("strip:0.15x0.03x24", kHeldEdge);
  const nlohmann::json film =
      Film(*fabric, Scaled(TestMaterial(), 1.0, 3.0), Eigen::Vector3d::Zero(),
           {.h = 0.00125, .steps = 160, .frames = {40, 80, 120, 160}});
  data_.density = TestMaterial().density;
  std::vector<double> factors;
  std::string measured;
  for (const char* mesh : {"strip:0.15x0.03x6", "strip:0.15x0.03x24"}) {
    StartFit(mesh, {{"steps", 160}, {"time_step", 0.00125}}, film, {});
    const nlohmann::json summary = Summary();
    factors.push_back(summary["measurements"][0]["mesh_factor"]);
    const std::string shape = summary["verdict"]["lamps"]["shape"].dump();
    const bool is_coarse = factors.size() == 1;
    EXPECT_EQ(shape.find("the mesh is too coarse for what was measured") < shape.size(), is_coarse);
    for (const auto& row : summary["laboratory"]["material"]["rows"])
      if (row["key"] == "bending_in_drape_un_m" && row["source"] == "measured") {
        const double bend = row["value"].get<double>() / Bend() * 3.0;
        EXPECT_LT(row["low"], bend) << mesh;
        EXPECT_GT(row["high"], bend) << mesh;
        measured = mesh;
      }
  }
  EXPECT_THAT(measured, testing::EndsWith("x24"));
  EXPECT_GT(factors[0], 4.0 * factors[1]);
}

// A time step that is too long for a motion says so; a shorter one gives the bending stiffness.
TEST_F(StripFitTest, AMotionByLongTimeStepsSaysSo) {
  spec_.stages.parameters = ParameterTying::kScales;
  const std::string mesh = "strip:0.15x0.0325x12";
  nlohmann::json film =
      Film(*MakeModel("strip:0.15x0.0325x48", kHeldEdge), Scaled(TestMaterial(), 1.0, 3.0),
           Eigen::Vector3d::Zero(), {.h = 0.0025, .steps = 160, .frames = {40, 80, 120, 160}}, 2);
  data_.density = TestMaterial().density;
  std::vector<double> factors;
  double bend = 0.0;
  for (const int longer : {8, 1}) {
    nlohmann::json measurements = film;
    for (auto& each : measurements) {
      each["step"] = each["step"].get<int>() / longer;
      each["sigma"] = 3e-3;
    }
    StartFit(mesh, {{"steps", 160 / longer}, {"time_step", 0.0025 * longer}}, measurements, {});
    const nlohmann::json summary = Summary();
    factors.push_back(summary["measurements"][0]["step_factor"]);
    const std::string shape = summary["verdict"]["lamps"]["shape"].dump();
    EXPECT_EQ(shape.find("the time step is too long for what was measured") < shape.size(),
              longer > 1);
    bend = Bend();  // at last by short steps
  }
  EXPECT_NEAR(bend, 3.0, 0.2);
  EXPECT_GT(factors[0], 5.0 * factors[1]);
}

// A coarse mesh and long time steps give the bending stiffness of a fall, since it is corrected by
// what finer ones would change: without, it is 3.04. Both meshes have triangles of one shape.
TEST_F(StripFitTest, AMotionIsCorrectedByTheErrorsOfItsGrid) {
  spec_.stages.parameters = ParameterTying::kScales;
  nlohmann::json film =
      Film(*MakeModel("strip:0.15x0.0325x48", kHeldEdge), Scaled(TestMaterial(), 1.0, 3.0),
           Eigen::Vector3d::Zero(), {.h = 0.005, .steps = 24, .frames = {6, 12, 18, 24}}, 8);
  for (auto& each : film) each["sigma"] = 1e-4;
  data_.density = TestMaterial().density;
  StartFit("strip:0.15x0.0325x12", {{"steps", 24}, {"time_step", 0.005}}, film, {});
  const nlohmann::json summary = Summary();
  EXPECT_LT(summary["measurements"][0]["mesh_factor"], 1.5);
  EXPECT_LT(summary["measurements"][0]["step_factor"], 1.5);
  EXPECT_NEAR(Bend(), 3.0, 0.01);
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
    const nlohmann::json summary = Summary();
    const int last_stage = summary["iterations"].get<int>() + 1;
    EXPECT_GT(summary["tangents"], last_stage) << "of two stages";
    EXPECT_GE(summary["rollouts"], summary["tangents"]);
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

// Nothing is at rest whose posterior could be found; tables of elements have no frequencies.
TEST_F(StripFitTest, ModelsBesideTheOneTableNeedACloth) {
  MakeModel("strip:0.06x0.02x6", kHeldEdge);
  const auto write = [&](const nlohmann::json& more) {
    nlohmann::json strip = {{"mesh", "strip:0.06x0.02x6"}, {"scene", "held.json"}};
    strip.update(more);
    data_.experiment = folder_ / "experiment.json";
    std::ofstream(data_.experiment) << nlohmann::json{{"experiments", {strip}}};
  };
  std::ofstream(folder_ / "m.csv") << "vertex,x_m,y_m,z_m\n4,0.05,0,0\n";
  spec_.model = FitModel::kBayes;
  write({{"motion", {{"steps", 2}, {"time_step", 0.02}}},
         {"measurements", {{{"markers", "m.csv"}, {"sigma", 1}, {"step", 2}}}}});
  EXPECT_THAT(ComputeError(), HasSubstr("model bayes: found motions alone"));
  spec_.model = FitModel::kHeterogeneous;
  write({{"measurements", {{{"frequencies", {2.0}}, {"sigma", 0.1}}}}});
  EXPECT_THAT(ComputeError(), HasSubstr("model heterogeneous: found frequencies"));
}

}  // namespace
}  // namespace drape::test
