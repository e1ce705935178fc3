// SPDX-License-Identifier: Apache-2.0
#include "solver/job/fit_verdict.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "solver/job/fit_report.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

using testing::HasSubstr;

// One bend entry in 15 of the mean, all equal: ln(mean) = mean of the log entries.
MaterialField UniformTables() {
  MaterialField field = test::TestMaterial();
  for (int r = 0; r < kStretchRows; ++r)
    for (int c = 0; c < kStretchCols; ++c) field.stretch[0].c[r][c] = c == 1 ? 10.0 : 100.0;
  for (auto& row : field.bend[0].b)
    for (double& entry : row) entry = 4e-5;
  return field;
}

TEST(EstimateStiffness, WithoutDataIsThePrior) {
  const StiffnessEstimates estimates = EstimateStiffness(
      UniformTables(), EqualStiffnessWeights(), TyingMatrix(ParameterTying::kEntries), {}, 2.0);
  EXPECT_NEAR(estimates.bend.value, 1e-5, 1e-18);
  EXPECT_NEAR(estimates.bend.log_deviation, 2.0 / std::sqrt(15.0), 1e-12);
  EXPECT_FALSE(estimates.bend.determined);
  EXPECT_NEAR(estimates.stretch.log_deviation, 2.0 / std::sqrt(12.0), 1e-12);
}

// A row a·(θ_bend) adds a² to the precision 1/σ² of the one factor on bend.
TEST(EstimateStiffness, AddsThePrecisionOfStrips) {
  WeightedRows rows;
  rows.jacobian = Eigen::RowVector2d(0.0, 20.0);
  const StiffnessEstimates estimates = EstimateStiffness(
      UniformTables(), EqualStiffnessWeights(), TyingMatrix(ParameterTying::kScales), rows, 0.5);
  EXPECT_NEAR(estimates.bend.log_deviation, 1 / std::sqrt(400.0 + 4.0), 1e-12);
  EXPECT_TRUE(estimates.bend.determined);
  EXPECT_NEAR(estimates.bend.factor(), std::exp(1.645 / std::sqrt(404.0)), 1e-12);
  EXPECT_NEAR(estimates.stretch.log_deviation, 0.5, 1e-12);
  EXPECT_FALSE(estimates.stretch.determined);
}

// What silhouettes of twins left uncertain is not hidden by a sharp outline, unless strips tell.
TEST(EstimateStiffness, AddsTheModelErrorOfOutlines) {
  const Eigen::MatrixXd tie = TyingMatrix(ParameterTying::kScales);
  WeightedRows rows;
  rows.jacobian = Eigen::MatrixXd::Identity(2, 2) * 1e3;
  rows.outline_rows = 2;
  const StiffnessEstimates outlines =
      EstimateStiffness(UniformTables(), EqualStiffnessWeights(), tie, rows, 1.0);
  EXPECT_TRUE(outlines.bend.determined);
  EXPECT_GT(outlines.bend.factor(), 1.6);
  EXPECT_FALSE(outlines.stretch.determined);
  rows.outline_weight = 1e-8;
  EXPECT_FALSE(
      EstimateStiffness(UniformTables(), EqualStiffnessWeights(), tie, rows, 1.0).bend.determined);
  rows.outline_rows = 1;
  EXPECT_LT(
      EstimateStiffness(UniformTables(), EqualStiffnessWeights(), tie, rows, 1.0).bend.factor(),
      1.01);
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
    report_.drapes = {drape};
    report_.stiffness =
        StiffnessEstimates{{.value = 100.0, .log_deviation = 0.1},
                           {.value = 1e-5, .log_deviation = 0.9, .determined = true}};
  }
  DrapeReport& drape() { return report_.drapes[0]; }
  SilhouetteMetrics& metrics() { return drape().fitted.metrics; }
  FitVerdict Judge() { return report_.verdict = JudgeFit(problem_, report_); }
  std::string Line() {
    Judge();
    return VerdictLine(problem_, report_);
  }

  FitProblem problem_;
  FitReport report_;
};

TEST_F(FitVerdictTest, AGoodFitSaysWhatToTrust) {
  EXPECT_EQ(Judge().grade, FitGrade::kGood);
  EXPECT_THAT(Line(), HasSubstr("verdict: good"));
  EXPECT_THAT(Line(), HasSubstr("bending of 10 uN m to a factor of 4.4"));
  EXPECT_THAT(Line(), HasSubstr("not stretching"));
  EXPECT_EQ(VerdictJson(report_).at("grade"), "good");
}

// The cube root of a factor on bending, and of bending over weight.
TEST_F(FitVerdictTest, WithoutADensityItTrustsTheBendingLength) {
  report_.density_is_given = false;
  report_.material.density = 0.2;
  EXPECT_THAT(Line(), HasSubstr("Trust a bending length of 17.2 mm to a factor of 1.6 (bending of "
                                "10 uN m if the cloth weighs 200 g/m2, as the start tables say)"));
}

// Beside the error that the data leave, that of the mesh; of the cube root a third.
TEST_F(FitVerdictTest, TheErrorOfTheMeshIsToldApart) {
  report_.mesh_error = MeshError{.log_stretch = 0.5, .log_bend = std::log(0.94)};
  EXPECT_THAT(Line(), HasSubstr("bending of 10 uN m to a factor of 4.4 (data) and 6.4 % (mesh)"));
  report_.density_is_given = false;
  report_.material.density = 0.2;
  EXPECT_THAT(Line(), HasSubstr("to a factor of 1.6 (data) and 2.1 % (mesh) (bending of"));
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
      {[&] { metrics().fitted.folds = 8; }, FitGrade::kUsable, "8 folds, the image has 7"},
      {[&] { metrics().fitted.folds = 4; }, FitGrade::kDoNotUse, "4 folds, the image has 7"},
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

TEST_F(FitVerdictTest, TheWorstComesFirst) {
  metrics().fitted.folds = 8;
  drape().lowest_eigenvalues.resize(0);
  EXPECT_THAT(Line(), HasSubstr("verdict: do not use: the fitted drape is not stable; 8 folds"));
  EXPECT_EQ(Line().find("Trust"), std::string::npos);
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
