// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_verdict.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/material/material_scaling.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/forward/drape_pool.h"
#include "solver/job/fit_report.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

using testing::HasSubstr;
using testing::Not;

// One bend entry in 15 of the mean, all equal: ln(mean) = mean of the log entries.
MaterialField UniformTables() {
  MaterialField field = test::TestMaterial();
  for (int r = 0; r < kStretchRows; ++r)
    for (int c = 0; c < kStretchCols; ++c) field.stretch[0].c[r][c] = c == 1 ? 10.0 : 100.0;
  for (auto& row : field.bend[0].b)
    for (double& entry : row) entry = 4e-5;
  return field;
}

double LogBend(const MaterialField& t) {
  return std::log(EffectiveBend(t, EqualStiffnessWeights()));
}

TEST(JudgeByLaplace, WithoutDataIsThePrior) {
  const Judgement judge =
      JudgeByLaplace(UniformTables(), TyingMatrix(ParameterTying::kEntries), {}, 2.0);
  const std::optional<KnownTo> bend = judge(LogBend, Resistance::kBending);
  ASSERT_TRUE(bend);
  EXPECT_NEAR(std::log(bend->high), 1.645 * 2.0 / std::sqrt(15.0), 1e-6);
  EXPECT_FALSE(bend->determined);
  EXPECT_NEAR(bend->left, 1.0, 1e-9);
}

// A row a·(θ_bend) adds a² to the precision 1/σ² of the one factor on bend.
TEST(JudgeByLaplace, AddsThePrecisionOfStrips) {
  WeightedRows rows;
  rows.jacobian = Eigen::RowVector2d(0.0, 20.0);
  const std::optional<KnownTo> bend =
      JudgeByLaplace(UniformTables(), TyingMatrix(ParameterTying::kScales), rows, 0.5)(
          LogBend, Resistance::kBending);
  EXPECT_TRUE(bend->determined);
  EXPECT_FALSE(bend->by_outlines);
  EXPECT_NEAR(std::log(bend->high), 1.645 / std::sqrt(404.0), 1e-6);
  EXPECT_NEAR(bend->left, 4.0 / 404.0, 1e-6);
}

// What silhouettes of twins left uncertain is not hidden by a sharp outline, unless strips tell.
TEST(JudgeByLaplace, AddsTheModelErrorOfOutlines) {
  const Eigen::MatrixXd tie = TyingMatrix(ParameterTying::kScales);
  WeightedRows rows;
  rows.jacobian = Eigen::MatrixXd::Identity(2, 2) * 1e3;
  rows.outline_rows = 2;
  const auto judge = [&](Resistance resistance) {
    return *JudgeByLaplace(UniformTables(), tie, rows, 1.0)(LogBend, resistance);
  };
  EXPECT_TRUE(judge(Resistance::kBending).determined);
  EXPECT_TRUE(judge(Resistance::kBending).by_outlines);
  EXPECT_GT(judge(Resistance::kBending).high, 1.6);
  EXPECT_FALSE(judge(Resistance::kStretching).determined);
  rows.outline_weight = 1e-8;
  EXPECT_FALSE(judge(Resistance::kBending).determined);
  rows.outline_rows = 1;
  EXPECT_LT(judge(Resistance::kBending).high, 1.01);
}

// The logarithm of any product of entries: here of c11/bend, of which the gradient is ±1.
TEST(JudgeByLaplace, KnowsTheGradientOfAnyQuantity) {
  const Eigen::MatrixXd tie = TyingMatrix(ParameterTying::kScales);
  WeightedRows rows;
  rows.jacobian = Eigen::RowVector2d(0.0, 20.0);
  const Judgement judge = JudgeByLaplace(UniformTables(), tie, rows, 0.5);
  const auto bend = [](const MaterialField& t) { return std::log(t.bend[0].b[1][2]); };
  const std::optional<KnownTo> known = judge(bend, Resistance::kBending);
  ASSERT_TRUE(known);
  EXPECT_TRUE(known->determined);
  EXPECT_NEAR(known->high, std::exp(1.645 / std::sqrt(404.0)), 1e-6);
  EXPECT_NEAR(known->low, 1 / known->high, 1e-9);
  const std::optional<KnownTo> ratio =
      judge([&](const MaterialField& t) { return std::log(t.stretch[0].c[0][0]) - bend(t); },
            Resistance::kStretching);
  ASSERT_TRUE(ratio);
  EXPECT_FALSE(ratio->determined);
  EXPECT_NEAR(ratio->high, std::exp(1.645 * std::sqrt(0.25 + 1 / 404.0)), 1e-4);
  // A cube root, such as a bending length, has a third of the error that silhouettes leave.
  WeightedRows outlines = rows;
  outlines.outline_rows = 1;
  const std::optional<KnownTo> length = JudgeByLaplace(UniformTables(), tie, outlines, 0.5)(
      [&](const MaterialField& t) { return bend(t) / 3; }, Resistance::kBending);
  EXPECT_NEAR(length->high, std::exp(1.645 / 3 * std::hypot(1 / std::sqrt(404.0), 0.3)), 1e-6);
  // Two entries that move together have a ratio that no number changes.
  EXPECT_FALSE(judge([&](const MaterialField& t) { return std::log(t.bend[0].b[0][2]) - bend(t); },
                     Resistance::kBending));
}

// Readings follow the compliance, so stiff cloth is excluded less than soft cloth; a compliance has
// the same ends the other way round. A ratio has no such end.
TEST(JudgeByLaplace, StretchesTheStiffEndOfExperiments) {
  const double information = 4.0, model = 1.645 * 0.3;
  WeightedRows rows;
  rows.jacobian = Eigen::RowVector2d(std::sqrt(information), 0.0);
  rows.outline_rows = 1;
  rows.tell_stretching = true;
  const Judgement judge =
      JudgeByLaplace(UniformTables(), TyingMatrix(ParameterTying::kScales), rows, 1.0);
  const auto stiffness = [](const MaterialField& t) { return std::log(t.stretch[0].c[0][0]); };
  const std::optional<KnownTo> stiff = judge(stiffness, Resistance::kStretching);
  ASSERT_TRUE(stiff);
  EXPECT_NEAR(std::log(stiff->low), -std::hypot(1.645 / std::sqrt(1.0 + information), model), 1e-6);
  const double far = std::sqrt(std::pow(std::log(stiff->high), 2) - model * model);
  EXPECT_NEAR(information * std::pow(1 - std::exp(-far), 2) + far * far, 1.645 * 1.645, 1e-4);
  const std::optional<KnownTo> soft =
      judge([&](const MaterialField& t) { return -stiffness(t); }, Resistance::kStretching);
  EXPECT_NEAR(soft->low * stiff->high, 1.0, 1e-9);
  EXPECT_NEAR(soft->high * stiff->low, 1.0, 1e-9);
  const std::optional<KnownTo> ratio =
      judge([&](const MaterialField& t) { return stiffness(t) - std::log(t.bend[0].b[0][0]); },
            Resistance::kStretching);
  EXPECT_GT(ratio->high, stiff->high);
}

class FitVerdictTest : public testing::Test {
 protected:
  FitVerdictTest() {
    Observation observation;
    observation.name = "drape";
    problem_.observations = {observation};
    report_.material = UniformTables();
    report_.density_is_given = true;
    report_.spectrum.determined = 5;
    DrapeReport drape;
    drape.fitted.x = Eigen::VectorXd::Zero(3);
    drape.fitted.metrics.profile_rms = 1.0;
    drape.fitted.metrics.image =
        drape.fitted.metrics.fitted = {.drape_coefficient = 0.5, .folds = 7};
    drape.force_residual = 1e-9;
    drape.lowest_eigenvalues = Eigen::Vector3d(1.0, 2.0, 3.0);
    drape.image_radius = drape.fitted.radius = Waves(7);
    report_.drapes = {drape};
    Know(KnownTo{0.5, 2.0, true, true});
  }
  // Profile [m] with that many folds of a peak-to-valley height.
  static Eigen::VectorXd Waves(int folds, double height = 0.02) {
    return 0.11 + 0.5 * height *
                      (folds * Eigen::ArrayXd::LinSpaced(kReportAngles, 0.0,
                                                         2 * M_PI * (1 - 1.0 / kReportAngles)))
                          .cos();
  }
  // The sheet of a fit that knows bending so well.
  void Know(std::optional<KnownTo> bending) {
    report_.fabric_sheet = MakeFabricSheet(
        {.tables = report_.material,
         .law = MakeLaw("smooth"),
         .weights = EqualStiffnessWeights(),
         .density_is_given = report_.density_is_given},
        [=](const LogQuantity&, Resistance resistance) {
          return resistance == Resistance::kBending ? bending : std::optional(KnownTo{});
        });
  }
  DrapeReport& drape() { return report_.drapes[0]; }
  SilhouetteMetrics& metrics() { return drape().fitted.metrics; }
  void SetFolds(int folds) {
    metrics().fitted.folds = folds;
    drape().fitted.radius = Waves(folds);
  }
  FitVerdict Judge() { return report_.verdict = JudgeFit(problem_, report_); }
  std::string Line() {
    Judge();
    return VerdictText(problem_, report_);
  }

  FitProblem problem_;
  FitReport report_;
};

TEST_F(FitVerdictTest, AGoodFitSaysWhatToTrust) {
  EXPECT_EQ(Judge().grade, FitGrade::kGood);
  EXPECT_THAT(Line(), HasSubstr("verdict: measurement good, shape good, bending good\n"));
  EXPECT_THAT(Line(), HasSubstr("coefficient is 50.0 %"));
  EXPECT_THAT(Line(), HasSubstr("bending rigidity B, as it drapes 10 µN·m (5 … 20), measured; "
                                "stretching is from the prior"));
  EXPECT_EQ(VerdictJson(report_.verdict).at("grade"), "good");
  EXPECT_EQ(VerdictJson(report_.verdict).at("lamps").at("bending").at("grade"), "good");
}

TEST_F(FitVerdictTest, WithoutADensityItTrustsTheBendingLength) {
  report_.density_is_given = false;
  report_.material.density = 0.2;
  Know(KnownTo{0.8, 1.25, true, true});
  EXPECT_THAT(Line(),
              HasSubstr("Trust bending length c, overall 1.721 cm (1.38 … 2.15), measured"));
}

TEST_F(FitVerdictTest, TheErrorOfTheMeshIsToldApart) {
  report_.mesh_error = MeshError{.log_stretch = 0.5, .log_bend = std::log(0.94)};
  EXPECT_THAT(Line(), HasSubstr("10 µN·m (5 … 20), measured, mesh 6.4 %"));
}

// A fit of red shape leaves the measurement alone, and the other way round.
TEST_F(FitVerdictTest, EachLampHasItsOwnReasons) {
  metrics().profile_rms = 6 * 719.5e-3;
  FitVerdict verdict = Judge();
  EXPECT_EQ(verdict.measurement.grade, FitGrade::kGood);
  EXPECT_EQ(verdict.shape.grade, FitGrade::kDoNotUse);
  EXPECT_EQ(verdict.bending.grade, FitGrade::kGood);
  metrics().profile_rms = 1.0;
  problem_.observations[0].quality.notes = {"the scale is assumed"};
  problem_.observations[0].quality.doubtful = true;
  verdict = Judge();
  EXPECT_THAT(verdict.measurement.reasons, testing::ElementsAre("the scale is assumed"));
  EXPECT_EQ(verdict.shape.grade, FitGrade::kGood);
  problem_.observations[0].quality = {};
  Know(KnownTo{});
  verdict = Judge();
  EXPECT_EQ(verdict.shape.grade, FitGrade::kGood);
  EXPECT_EQ(verdict.bending.grade, FitGrade::kDoNotUse);
  EXPECT_THAT(Line(), HasSubstr("Bending is from the prior"));
}

// Folds lower than the outline's error are neither there nor missing: 3 folds of 2.8 mm where the
// image has none that is as high, at an error of .8 mm.
TEST_F(FitVerdictTest, FoldsBelowTheErrorOfTheOutlineDoNotCount) {
  metrics().profile_rms = 0.8 * 719.5e-3;
  metrics().fitted.folds = 3;
  metrics().image.folds = 0;
  drape().image_radius = Waves(3, 0.0023);
  drape().fitted.radius = Waves(3, 0.0028);
  EXPECT_EQ(Judge().grade, FitGrade::kGood);
  drape().fitted.radius = Waves(3, 0.0060);
  drape().image_radius = Waves(3, 0.0001);
  EXPECT_EQ(Judge().shape.grade, FitGrade::kDoNotUse);
  EXPECT_EQ(Judge().bending.grade, FitGrade::kUsable);
}

// The material explains the error of a grid that is much too coarse, whatever the intervals say.
TEST_F(FitVerdictTest, AMotionOfAGridThatIsMuchTooCoarseIsNotToBeUsed) {
  report_.measurements = {{.experiment = "swing", .name = "markers", .count = 300, .misfit = 0.9}};
  MeasurementReport& motion = report_.measurements.front();
  for (double* const factor : {&motion.mesh_factor, &motion.step_factor}) {
    EXPECT_EQ(Judge().grade, FitGrade::kGood);
    *factor = 4.0;
    EXPECT_EQ(Judge().shape.grade, FitGrade::kUsable);
    EXPECT_EQ(Judge().bending.grade, FitGrade::kGood);
    *factor = 6.0;
    EXPECT_EQ(Judge().shape.grade, FitGrade::kDoNotUse);
    EXPECT_EQ(Judge().bending.grade, FitGrade::kDoNotUse);
    *factor = 1.0;
  }
}

// Twins are met less closely by fewer numbers, and by larger specimens.
TEST_F(FitVerdictTest, TheLimitOfTheOutlineIsThatOfTheModel) {
  metrics().profile_rms = 3.5 * 719.5e-3;
  EXPECT_EQ(Judge().shape.grade, FitGrade::kUsable);
  report_.spectrum.values = Eigen::VectorXd::Ones(2);
  EXPECT_EQ(Judge().shape.grade, FitGrade::kGood);
  report_.spectrum.values = Eigen::VectorXd::Ones(39);
  EXPECT_EQ(Judge().shape.grade, FitGrade::kUsable);
  problem_.observations[0].discs.specimen = 0.18;
  EXPECT_EQ(Judge().shape.grade, FitGrade::kGood);
}

// Specimens differ by design: the scatter of their images counts, and the mean has to be right.
TEST_F(FitVerdictTest, OneTableIsJudgedByTheScatterOfSpecimens) {
  problem_.observations.push_back(problem_.observations[0]);
  metrics().profile_rms = 5.2 * 719.5e-3;
  report_.drapes.push_back(drape());
  report_.drapes[0].fitted.metrics.image.drape_coefficient = 0.472;
  report_.drapes[1].fitted.metrics.image.drape_coefficient = 0.528;
  for (const std::vector<int>& one : {std::vector<int>(), {1, 1}}) {
    problem_.specimens = one;
    EXPECT_EQ(Judge().shape.grade, FitGrade::kDoNotUse);
  }
  problem_.specimens = {1, 2};
  EXPECT_EQ(Judge().shape.grade, FitGrade::kGood);
  metrics().profile_rms = 8 * 719.5e-3;
  EXPECT_THAT(Line(), HasSubstr("an outline error of 8.0 mm (5.8 px), expected at most 5.5 mm"));
  metrics().profile_rms = 1.0;
  for (DrapeReport& each : report_.drapes) each.fitted.metrics.fitted.drape_coefficient = 0.56;
  EXPECT_EQ(Judge().shape.grade, FitGrade::kDoNotUse);
  EXPECT_THAT(Line(), HasSubstr("a mean drape coefficient of 56.0 %, the images have 50.0 %"));
  // Two fabrics are no specimens of one.
  for (int i = 0; i < 2; ++i) {
    report_.drapes[i].fitted.metrics.fitted.drape_coefficient = 0.5;
    report_.drapes[i].fitted.metrics.image.drape_coefficient = 0.35 + 0.3 * i;
  }
  EXPECT_EQ(Judge().shape.grade, FitGrade::kDoNotUse);
}

// The ratio of the stiffer to the softer direction says nothing of the stiffness.
TEST_F(FitVerdictTest, ARatioAloneIsNoStiffness) {
  report_.fabric_sheet = MakeFabricSheet(
      {.tables = report_.material,
       .law = MakeLaw("smooth"),
       .weights = EqualStiffnessWeights(),
       .density_is_given = true,
       .directions = NameDirections(false, 2, 1)},
      [&](const LogQuantity& quantity, Resistance) {
        const bool is_ratio = std::abs(BendDegree(quantity, report_.material)) < 1e-6;
        return std::optional(KnownTo{0.9, 1.1, is_ratio});
      });
  EXPECT_TRUE(report_.fabric_sheet->of("bending_ratio").measured());
  EXPECT_EQ(Judge().bending.grade, FitGrade::kDoNotUse);
}

TEST_F(FitVerdictTest, ABoundIsNeverGood) {
  Know(KnownTo{0.5, std::numeric_limits<double>::infinity(), true, true});
  EXPECT_EQ(Judge().bending.grade, FitGrade::kUsable);
  EXPECT_THAT(Line(), HasSubstr("as it drapes at least 5 µN·m, measured"));
}

// A cloth that hardly differs from the flat one, or a guess at an edge of its grid that the prior
// holds, bound the rigidity from one side.
TEST_F(FitVerdictTest, FindsWhatBoundsFromOneSide) {
  const InitialGuessOptions grid;
  const auto bound = [&](double guess, double left) {
    InitialGuess at;
    at.bend = guess;
    return FindBendBound(problem_, report_, grid, at, left);
  };
  EXPECT_EQ(bound(8.0, 0.05), Bound::kNone);
  EXPECT_EQ(bound(8.0, 0.3), Bound::kAtLeast);
  EXPECT_EQ(bound(0.06, 0.3), Bound::kAtMost);
  EXPECT_EQ(bound(4.0, 0.3), Bound::kNone);
  drape().image_radius.setConstant(0.1495);
  EXPECT_EQ(bound(1.0, 0.05), Bound::kAtLeast);
  drape().image_radius.setConstant(0.1476);  // a drape coefficient of 95 %
  EXPECT_EQ(bound(1.0, 0.05), Bound::kNone);
  // 1.4 mm at most, of which the outline's 1.39 mm are the larger part: c is more than 4 cm.
  drape().image_radius.setConstant(0.15);
  const double c = BendingLength(LeastRigidityOfFlat(problem_, report_), report_.material.density);
  EXPECT_NEAR(c, 0.06 * std::pow(0.06 / (448 * 1e-3 / 0.7195), 1 / 6.0), 1e-4);
}

// The start tables that a pool gave have no grid: the pool's range is what they end at.
TEST_F(FitVerdictTest, APooledGuessBoundsAtTheEndsOfItsRange) {
  const NumberRange& range = NumberRanges()[kLogBendingLength];
  const auto bound = [&](double log_length) {
    problem_.is_pooled = true;
    problem_.material = report_.material;
    const double now =
        std::log(BendingLength(MeanBend(problem_.material.bend[0]), problem_.material.density));
    problem_.material = Scaled(problem_.material, 1.0, std::exp(3 * (log_length - now)));
    return FindBendBound(problem_, report_, {}, {}, 0.3);
  };
  EXPECT_EQ(bound(0.5 * (range.low + range.high)), Bound::kNone);
  EXPECT_EQ(bound(range.high), Bound::kAtLeast);
  EXPECT_EQ(bound(range.low), Bound::kAtMost);
}

// Each criterion alone lowers the grade, and is named.
TEST_F(FitVerdictTest, EachFaultIsFoundAndNamed) {
  struct Fault {
    std::function<void()> plant;
    FitGrade grade;
    std::string named;
  };
  const double pixels = 719.5e-3;  // a millimetre
  const std::vector<Fault> faults = {
      {[&] { metrics().profile_rms = 4 * pixels; }, FitGrade::kUsable, "outline error of 4.0 mm"},
      {[&] { metrics().profile_rms = 6 * pixels; }, FitGrade::kDoNotUse, "outline error of 6.0 mm"},
      {[&] { SetFolds(8); }, FitGrade::kUsable, "8 folds, the image has 7"},
      {[&] { SetFolds(4); }, FitGrade::kDoNotUse, "4 folds, the image has 7"},
      {[&] { metrics().fitted.drape_coefficient = 0.53; }, FitGrade::kUsable, "53.0 %"},
      {[&] { metrics().fitted.drape_coefficient = 0.6; }, FitGrade::kDoNotUse, "60.0 %"},
      {[&] { drape().force_residual = 1e-2; }, FitGrade::kDoNotUse, "not at rest"},
      {[&] { drape().force_residual = std::numeric_limits<double>::quiet_NaN(); },
       FitGrade::kDoNotUse, "not at rest"},
      {[&] { drape().lowest_eigenvalues[0] = -1; }, FitGrade::kDoNotUse, "not stable"},
      {[&] { drape().self_intersections = 3; }, FitGrade::kDoNotUse,
       "passes through itself, in 3 pairs of faces"},
      {[&] { drape().drift = 0.01; }, FitGrade::kDoNotUse, "nudged, it comes to rest 10.0 mm away"},
      {[&] { drape().status = EquilibriumStatus::kNotConverged; }, FitGrade::kDoNotUse,
       "does not come to rest"},
      {[&] { drape().fitted.x.resize(0); }, FitGrade::kDoNotUse, "no outline"},
      {[&] { problem_.observations[0].quality.doubtful = true; }, FitGrade::kUsable,
       "of the image may be off"},
      {[&] { report_.cancelled = true; }, FitGrade::kDoNotUse, "cancelled"},
      {[&] { report_.spectrum.determined = 0; }, FitGrade::kDoNotUse, "determine nothing"},
      {[&] { report_.material.stretch[0].c[2][1] = 99.5; }, FitGrade::kUsable, "at the limit"},
      {[&] { report_.posterior.emplace().pareto_k = 1.3; }, FitGrade::kUsable, "Pareto k 1.30"},
      {[&] { report_.material = {}; }, FitGrade::kDoNotUse, "nothing could be fitted"}};
  const FitReport good = report_;
  const std::vector<Observation> observations = problem_.observations;
  for (const Fault& fault : faults) {
    report_ = good;
    problem_.observations = observations;
    fault.plant();
    EXPECT_EQ(Judge().grade, fault.grade) << fault.named;
    EXPECT_THAT(Line(), HasSubstr(fault.named));
  }
}

// A cloth that hardly stretches explains what another does, with a misfit as small.
TEST_F(FitVerdictTest, AFitFarFromItsStartTablesIsNotGood) {
  report_.drapes.clear();
  report_.measurements = {{.experiment = "strip", .name = "markers", .count = 45, .misfit = 1.1}};
  report_.start = report_.material;
  EXPECT_EQ(Judge().grade, FitGrade::kGood);
  report_.start = Scaled(report_.material, 1 / 515.0, 1 / 12.4);
  EXPECT_EQ(Judge().bending.grade, FitGrade::kUsable);
  EXPECT_THAT(Line(), HasSubstr("the stretching stiffness ends at 515 times the start tables'"));
  EXPECT_THAT(Line(), Not(HasSubstr("the bending stiffness ends at")));
}

// An answer at once that the fit contradicts leaves it in doubt.
TEST_F(FitVerdictTest, PooledDrapesThatSayOtherwiseLowerTheBending) {
  const double length = report_.fabric_sheet->of("bending_length_overall_cm").value;
  const auto at_once = [&](double factor) {
    report_.at_once = {{.title = "at once",
                        .rows = {{.key = "bending_length_overall_cm",
                                  .name = "bending length c, overall",
                                  .value = factor * length,
                                  .unit = "cm",
                                  .interval = LaboratoryRow::Interval{0.9 * factor * length,
                                                                      1.1 * factor * length},
                                  .source = kMeasured}}}};
    return Judge().bending.grade;
  };
  EXPECT_EQ(at_once(1.0), FitGrade::kGood);
  EXPECT_EQ(at_once(2.5), FitGrade::kUsable);
  EXPECT_THAT(Line(), HasSubstr("pooled drapes like the image say otherwise"));
}

TEST_F(FitVerdictTest, TheWorstComesFirst) {
  SetFolds(8);
  drape().lowest_eigenvalues.resize(0);
  EXPECT_THAT(Line(), HasSubstr("shape: do not use: the fitted drape is not stable; 8 folds"));
  EXPECT_THAT(Line(), HasSubstr("bending: do not use: the fitted drape is not stable; 8 folds"));
  EXPECT_THAT(Judge().reasons, testing::Contains("the fitted drape is not stable").Times(1));
}

TEST_F(FitVerdictTest, ReadingsOfStripsCount) {
  report_.drapes.clear();
  report_.strips.push_back(
      {.measurement = {.name = "warp", .sigma = 0.5, .points = {{0.1, 41.5}}}, .computed = {44.0}});
  EXPECT_EQ(Judge().grade, FitGrade::kDoNotUse);
  EXPECT_THAT(Line(), HasSubstr("warp is off by up to 5.0 sigma"));
}

}  // namespace
}  // namespace drape
