// SPDX-License-Identifier: Apache-2.0
// Fits of mechanical tests, alone and beside outlines.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "physics/material/material_io.h"
#include "physics/util/json_input.h"
#include "solver/fit/strips.h"
#include "solver/job/fit_job.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"
#include "tests/solver/fit/observed/write_lab_measurement.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr double kDegree = M_PI / 180.0;

class LabFitTest : public FileFixture {
 protected:
  LabFitTest() {
    start_ = reference_ = test::TestMaterial();
    for (BendTable& table : reference_.bend)
      for (int r = 0; r < kBendRows; ++r)
        for (double& entry : table.b[r]) entry *= 0.4 + 0.15 * r;
    for (StretchTable& table : reference_.stretch)
      for (auto& row : table.c) row[0] *= 1.5, row[2] *= 1.2;
    data_.material = WriteTables("start.json", start_);
    data_.ground_truth = WriteTables("reference.json", reference_);
    files_.out = Path("");
    files_.checkpoint = Path("checkpoint.json");
    files_.log = Path("fit.log");
  }

  std::string WriteTables(const std::string& name, const MaterialField& field) const {
    WriteMaterial(Path(name), {.name = "tables",
                               .field = field,
                               .source_convention = "arcsim",
                               .source = "",
                               .warnings = {}});
    return Path(name);
  }

  // A test of the true cloth, exact to rounding.
  void AddTest(LabMeasurement test) {
    const auto readings = Strips({test}, MakeLaw("smooth")).Compute(reference_);
    ASSERT_TRUE(readings);
    for (std::size_t i = 0; i < test.points.size(); ++i) test.points[i].reading = (*readings)[i];
    const std::string file =
        Path(std::string(ToString(test.kind)) + std::to_string(int(test.direction)) + ".json");
    test::WriteLabMeasurement(file, test);
    data_.lab_measurements.push_back(file);
  }
  void AddCantilever(double direction, double sigma = 0.05) {
    AddTest({.kind = LabMeasurementKind::kCantilever,
             .direction = direction,
             .sigma = sigma,
             .points = {{0.04, 0}, {0.06, 0}}});
  }
  void AddTensile(double direction) {
    AddTest({.kind = LabMeasurementKind::kTensile,
             .direction = direction,
             .length = 0.2,
             .width = 0.05,
             .sigma = 1e-4,
             .points = {{0.05, 0}, {0.1, 0}, {0.2, 0}}});
  }
  MaterialField Fitted() const { return ReadMaterial(Path("material.json")).field; }
  nlohmann::json Summary() const { return ReadJsonFile(Path("summary.json")); }
  // What a strip shows that is not among the data.
  double Reading(const MaterialField& material, LabMeasurement test) const {
    return Strips({std::move(test)}, MakeLaw("smooth")).Compute(material).value()[0];
  }

  MaterialField start_, reference_;
  FitSpec spec_;
  FitData data_;
  FitFiles files_;
};

TEST_F(LabFitTest, RecoversWhatTheTestsDetermine) {
  spec_.stages.parameters = ParameterTying::kColumns;
  for (const double direction : {0.0, 90.0}) {
    AddCantilever(direction);
    AddTensile(direction);
  }
  const FitJobResult result = RunFitJob(spec_, data_, files_, {});
  ASSERT_TRUE(result.fitted);
  EXPECT_THAT(result.table, testing::HasSubstr("cantilever90"));
  const MaterialField fitted = Fitted();
  for (const double direction : {0.0, 90.0}) {
    const LabMeasurement bend{
        .kind = LabMeasurementKind::kCantilever, .direction = direction, .points = {{0.05, 0}}};
    const auto rigidity = [&](const MaterialField& material) {
      return EstimateBending(0.05, Reading(material, bend), material.density).rigidity;
    };
    EXPECT_NEAR(rigidity(fitted) / rigidity(reference_), 1.0, 0.01) << direction;
    EXPECT_GT(std::abs(rigidity(start_) / rigidity(reference_) - 1.0), 0.3);
    const LabMeasurement pull{.kind = LabMeasurementKind::kTensile,
                              .direction = direction,
                              .length = 0.2,
                              .width = 0.05,
                              .points = {{0.15, 0}}};
    const auto strain = [&](const MaterialField& material) { return Reading(material, pull) - 1; };
    EXPECT_NEAR(strain(fitted) / strain(reference_), 1.0, 0.01) << direction;
    EXPECT_GT(std::abs(strain(start_) / strain(reference_) - 1.0), 0.1);
  }
}

TEST_F(LabFitTest, ItsSummaryHasEachPointAndTheStandardsEstimate) {
  spec_.stages.parameters = ParameterTying::kScales;
  AddCantilever(90.0);
  RunFitJob(spec_, data_, files_, {});
  const nlohmann::json summary = Summary();
  EXPECT_EQ(summary["status"], "done");
  EXPECT_EQ(summary["spectrum"]["singular_values"].size(), 2);
  EXPECT_EQ(summary["spectrum"]["determined_directions"], 1);
  EXPECT_FALSE(summary.contains("mesh"));
  const nlohmann::json& test = summary["lab_measurements"][0];
  EXPECT_EQ(test["test"], "cantilever");
  EXPECT_EQ(test["direction"], 90.0);
  ASSERT_EQ(test["points"].size(), 2);
  const nlohmann::json& point = test["points"][1];
  EXPECT_EQ(point["length"], 0.06);
  EXPECT_NEAR(point["angle_computed"].get<double>() - point["angle"].get<double>(),
              0.05 * point["residual"].get<double>(), 1e-9);
  const double c = point["bending_length_m"];
  EXPECT_NEAR(point["flexural_rigidity"].get<double>(), 0.2 * 9.80665 * c * c * c, 1e-12);
  EXPECT_EQ(point["flexural_rigidity"],
            EstimateBending(0.06, point["angle"], reference_.density).rigidity);
}

TEST(EstimateBending, HalfTheOverhangAtTheAngleOfTheStandard) {
  EXPECT_NEAR(EstimateBending(0.06, 41.5, 0.2).length, 0.03, 1e-5);
  EXPECT_TRUE(std::isnan(EstimateBending(0.06, 90.0, 0.2).length));
}

TEST_F(LabFitTest, NeitherImagesNorTestsIsAnError) {
  EXPECT_INPUT_ERROR(RunFitJob(spec_, data_, files_, {}),
                     "images: found no silhouette and no lab_tests");
}

TEST_F(LabFitTest, TheDensityThatWasWeighedCounts) {
  spec_.stages.parameters = ParameterTying::kScales;
  AddCantilever(0.0);
  data_.density = 0.3;
  RunFitJob(spec_, data_, files_, {});
  EXPECT_EQ(Fitted().density, 0.3);
  // The bending length is what was measured: a heavier cloth is stiffer.
  EXPECT_NEAR(DirectionalRigidity(Fitted().bend[0], 0.0) /
                  (1.5 * DirectionalRigidity(reference_.bend[0], 0.0)),
              1.0, 0.05);
}

// A cloth far from the start tables, and a reading that contradicts another.
TEST_F(LabFitTest, MeetsAFarReadingAndNotesOneThatNothingMeets) {
  const auto fit = [&](std::vector<LabPoint> points) {
    test::WriteLabMeasurement(Path("far.json"), {.kind = LabMeasurementKind::kTensile,
                                                 .direction = 90.0,
                                                 .length = 0.2,
                                                 .width = 0.05,
                                                 .sigma = 0.002,
                                                 .points = std::move(points)});
    data_.lab_measurements = {Path("far.json")};
    EXPECT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted);
    return Summary();
  };
  const nlohmann::json far = fit({{95.0, 1.02}});
  EXPECT_LT(std::abs(far["lab_measurements"][0]["points"][0]["residual"].get<double>()), 0.5);
  EXPECT_TRUE(far["notes"].empty());
  const nlohmann::json torn = fit({{1.0, 1.02}, {1.0, 1.06}});
  ASSERT_FALSE(torn["notes"].empty());
  EXPECT_THAT(torn["notes"][0].get<std::string>(),
              testing::HasSubstr("laboratory measurement far: the computed reading at 1"));
}

// Beside an outline of the true cloth, stiff so that its branch is found; and after an
// interruption, the same bits.
class JointFit : public LabFitTest {
 protected:
  JointFit() {
    for (BendTable& table : reference_.bend)
      for (double& entry : std::span(&table.b[0][0], kBendEntries)) entry *= 10.0;
    const auto backend = test::SmoothDisc(300);
    const State drape = test::Settled(*backend, reference_, test::RandomStart(backend->model(), 1));
    const Observation observation =
        test::MakeObservation(backend->model().mesh, drape, 72, "drape");
    WritePng(observation.image, Path("drape.png"));
    data_.images = {Path("drape.png")};
    spec_.mesh = "disc:300";
    spec_.coarse_mesh = "disc:100";
    spec_.stages.grid.lifts = {0.6, 1.0};
    spec_.stages.grid.stretch = {1.0, 2.0};
    spec_.stages.candidates_per_round = {2, 1};
    spec_.stages.iterations = {5, 25};
    spec_.observation.angles = 72;
    spec_.observation.warp = "up";
    AddCantilever(0.0, 0.5);
    AddCantilever(90.0, 0.5);
  }
};

TEST_F(JointFit, AgreesWithTestsAndOutline) {
  ASSERT_TRUE(RunFitJob(spec_, data_, files_, {}).fitted) << Read(Path("fit.log")) << Summary();
  const nlohmann::json summary = Summary();
  EXPECT_LT(summary["images"][0]["metrics"]["profile_rms_px"].get<double>(), 0.3);
  EXPECT_EQ(summary["initial_guess"]["bend"], 1.0);  // a cantilever has measured it
  ASSERT_EQ(summary["lab_measurements"].size(), 2);
  for (const nlohmann::json& test : summary["lab_measurements"])
    for (const nlohmann::json& point : test["points"])
      EXPECT_LT(std::abs(point["residual"].get<double>()), 3.0) << point;
  EXPECT_GT(summary["spectrum"]["determined_directions"],
            summary["lab_fit"]["spectrum"]["determined_directions"]);
}

// A weak outline and a strip: the posterior is as narrow as the strip makes it.
TEST_F(JointFit, ThePosteriorHasTheTestsToo) {
  spec_.model = FitModel::kBayes;
  spec_.stages.parameters = ParameterTying::kScales;
  spec_.stages.residuals.sigma_px = 5.0;
  spec_.posterior.estimate_sigma = false;
  spec_.posterior.specimen_stretch_sigma = spec_.posterior.specimen_bend_sigma = 0.0;
  spec_.posterior.draws = 4;
  spec_.posterior.rank = 0;
  spec_.posterior.iterations = 4;
  spec_.posterior.elbo_samples = 25;
  const auto deviation = [&]() -> double {
    EXPECT_TRUE(RunFitJob(spec_, data_, files_, {}).has_posterior);
    return Summary()["posterior"]["log_factors"][1]["sd"];
  };
  const double both = deviation();
  data_.lab_measurements.clear();
  const double alone = deviation();
  std::printf("%g with the strips, %g without\n", both, alone);
  EXPECT_LT(both, 0.5 * alone);
}

TEST_F(JointFit, GoesOnAfterACancelToTheSameBitsAndKnowsItsTests) {
  spec_.stages.parameters = ParameterTying::kColumns;
  spec_.stages.iterations = {2, 2};
  RunFitJob(spec_, data_, files_, {});
  const std::string whole = Read(Path("material.json"));
  std::atomic<bool> cancel = false;
  const RunControl stop{&cancel, [&](double, const std::string& note) {
                          if (note.starts_with("round 1")) cancel = true;
                        }};
  EXPECT_TRUE(RunFitJob(spec_, data_, files_, stop).cancelled);
  files_.resume = true;
  EXPECT_FALSE(RunFitJob(spec_, data_, files_, {}).cancelled);
  EXPECT_EQ(Read(Path("material.json")), whole);
  files_.resume = false;
  cancel = false;
  EXPECT_TRUE(RunFitJob(spec_, data_, files_, stop).cancelled);
  files_.resume = true;
  data_.lab_measurements.pop_back();
  EXPECT_INPUT_ERROR(RunFitJob(spec_, data_, files_, {}), "run without --resume");
}

}  // namespace
}  // namespace drape
