// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/exchange_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "physics/material/material_scaling.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/prediction/exchange/fabric_sheet.h"
#include "solver/prediction/exchange/targets/export_material.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"
#include "tests/physics/simulation/closed_forms.h"
#include "tests/solver/prediction/exchange/twill.h"

namespace drape {
namespace {

using test::kTwill;
using testing::AllOf, testing::AnyOf, testing::HasSubstr, testing::Not;

MaterialField Tables();

class ExchangeRecordTest : public FileFixture {
 protected:
  // Two factors, on all stretch and on all bend entries: bend known to 10 %, stretch not at all.
  static StoredPosterior Scales() {
    StoredPosterior posterior;
    posterior.fabric = ParameterTying::kScales;
    posterior.base = test::TestMaterial();
    posterior.prior_sd.resize(2);
    posterior.prior_sd << 1.0, 0.8;
    posterior.mean.resize(2);
    posterior.mean << 0.2, -0.5;
    posterior.covariance.resize(2, 2);
    posterior.covariance << 1.0, 0.0, 0.0, 0.01;
    return posterior;
  }
  static const LaboratoryRow& Number(const ExchangeRecord& record, const std::string& key) {
    for (const LaboratoryRow& number : record.numbers)
      if (number.key == key) return number;
    throw std::out_of_range(key);
  }
};

TEST_F(ExchangeRecordTest, APosteriorTellsMeasuredFromPrior) {
  WritePosterior(Path(""), Scales(), "test");
  const Law law = MakeLaw("smooth");
  const FabricSource source = ReadFabric(Path(""));
  const ExchangeRecord record = MakeRecord(source, law, {});
  const LinearFabric base = LineariseAtRest(test::TestMaterial(), law);
  // Two factors do not tell how bending differs between the directions.
  const LaboratoryRow& bend = Number(record, "bend_weft");
  EXPECT_NEAR(bend.value, base.bend_weft * std::exp(-0.5), 1e-9 * bend.value);
  EXPECT_FALSE(bend.measured());
  EXPECT_FALSE(bend.interval);
  const LaboratoryRow& stretch = Number(record, "c11");
  EXPECT_NEAR(stretch.value, base.c11 * std::exp(0.2), 1e-9 * stretch.value);
  EXPECT_FALSE(stretch.measured());
  const nlohmann::ordered_json json = RecordJson(record);
  EXPECT_EQ(json.at("linear").at("c11").at("source"), "from the prior");
  EXPECT_EQ(json.at("tables").at("stretch").size(), 6u);
  EXPECT_EQ(json.at("thickness"), nullptr);
}

// Where a fit does not know which direction is the warp, no number of an export does.
TEST_F(ExchangeRecordTest, NamesAStifferDirectionWhereTheWarpIsNotKnown) {
  StoredPosterior posterior = Scales();
  posterior.base = Tables();
  posterior.warp_known = false;
  WritePosterior(Path(""), posterior, "test");
  const Law law = MakeLaw("smooth");
  const FabricSource source = ReadFabric(Path(""));
  const ExchangeRecord record = MakeRecord(source, law, {});
  EXPECT_NEAR(Number(record, "bend_stiffer").value / Number(record, "bend_softer").value, 4, 1e-9);
  const nlohmann::ordered_json json = RecordJson(record);
  EXPECT_EQ(json.at("directions"), (nlohmann::ordered_json{"stiffer", "softer"}));
  EXPECT_THAT(json.dump(), Not(AnyOf(HasSubstr("warp"), HasSubstr("weft"))));
  EXPECT_THAT(PosteriorCsv(source, law, {.draws = 4}),
              AllOf(HasSubstr(",bend_softer,bend_stiffer,"), Not(HasSubstr("warp"))));
  EXPECT_THAT(ExportMaterial(ExportTarget::kPpf, record).lost,
              testing::Contains(HasSubstr("here it is the stiffer one")));
  posterior.warp_known = true;
  WritePosterior(Path(""), posterior, "test");
  EXPECT_EQ(Number(MakeRecord(ReadFabric(Path("")), law, {}), "bend_warp").value,
            16e-6 * std::exp(-0.5));
}

// What a fit has stated is not judged again: its origins stay, its intervals as shares, whatever
// its drapes have named the directions.
TEST_F(ExchangeRecordTest, RepeatsWhatTheFitStates) {
  WritePosterior(Path(""), Scales(), "test");
  const FabricSheetInput input{.tables = test::TestMaterial(),
                               .law = MakeLaw("smooth"),
                               .weights = EqualStiffnessWeights(),
                               .density_is_given = true,
                               .directions = NameDirections(false, 1, 2)};
  const LaboratorySheet sheet =
      MakeLinearSheet(input, [](const LogQuantity&, Resistance resistance) {
        return std::optional(KnownTo{0.5, 3.0, resistance == Resistance::kBending});
      });
  const nlohmann::json summary = {{"posterior", nlohmann::json::object()},
                                  {"laboratory", {{"linear", SheetJson(sheet)}}}};
  Write("summary.json", summary.dump());
  const ExchangeRecord record = MakeRecord(ReadFabric(Path("")), input.law, {});
  const LaboratoryRow& bend = Number(record, "bend_weft");
  EXPECT_EQ(bend.source, "measured");
  EXPECT_NEAR(bend.interval->low, 0.5 * bend.value, 1e-9 * bend.value);
  EXPECT_NEAR(bend.interval->high, 3.0 * bend.value, 1e-9 * bend.value);
  EXPECT_EQ(Number(record, "c22").source, "from the prior");
  EXPECT_FALSE(Number(record, "c22").interval);
}

TEST_F(ExchangeRecordTest, SamplesHaveTheMomentsOfThePosterior) {
  StoredPosterior posterior = Scales();
  posterior.covariance << 0.5, 0.06, 0.06, 0.01;
  const FabricSamples samples = SampleFabric(posterior, 4000, 1);
  EXPECT_EQ(samples.names, (std::vector<std::string>{"stretch", "bend"}));
  const Eigen::MatrixXd deviation =
      samples.log_factors.colwise() - samples.log_factors.rowwise().mean();
  const Eigen::Matrix2d covariance = deviation * deviation.transpose() / 3999.0;
  EXPECT_NEAR(covariance(0, 0), 0.5, 0.05);
  EXPECT_NEAR(covariance(0, 1), 0.06, 0.006);
  EXPECT_NEAR(covariance(1, 1), 0.01, 0.001);
  EXPECT_NEAR(samples.log_factors.row(1).mean(), -0.5, 0.01);
  EXPECT_NEAR(samples.tables[7].bend[0].b[1][2],
              posterior.base.bend[0].b[1][2] * std::exp(samples.log_factors(1, 7)), 1e-12);
  const FabricSamples prior = SamplePrior(posterior, 4000, 1);
  EXPECT_NEAR(std::sqrt(prior.log_factors.row(0).squaredNorm() / 4000.0), 1.0, 0.05);
}

TEST_F(ExchangeRecordTest, AMaterialFileHasNoUncertainty) {
  const std::string file = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json";
  const Law law = MakeLaw("smooth");
  const ExchangeRecord record = MakeRecord(ReadFabric(file), law, {});
  EXPECT_EQ(record.source.material.name, "synthetic_wool");
  EXPECT_FALSE(record.numbers[0].interval);
  EXPECT_EQ(RecordJson(record).at("linear").at("c11").at("source"), "not known");
}

TEST_F(ExchangeRecordTest, RefusesWhatIsNoFabric) {
  EXPECT_INPUT_ERROR(ReadFabric(Path("")), "found no material.json");
  EXPECT_INPUT_ERROR(ReadFabric(Path("none.json")), "none.json");
  Write("field.json", R"({"format": "drapefit-material-field"})");
  EXPECT_INPUT_ERROR(ReadFabric(Path("field.json")), "a table for each element");
}

// c11 = 300 (weft), c22 = 600 (warp), c12 = 60, G = 20 N/m; B = 16 along the warp, 4 along the
// weft, 8 µN·m along the bias; 150 g/m².
MaterialField Tables() {
  return TablesFrom({.c11 = 300.0,
                     .c22 = 600.0,
                     .c12 = 60.0,
                     .shear = 20.0,
                     .bend_weft = 4e-6,
                     .bend_warp = 16e-6,
                     .bend_bias = 8e-6,
                     .density = 0.15});
}

LaboratorySheet Sheet(const Judgement& judge, bool density_is_given = true,
                      const std::vector<LabMeasurement>& tests = {}) {
  return MakeFabricSheet({.tables = Tables(),
                          .law = MakeLaw("smooth"),
                          .weights = EqualStiffnessWeights(),
                          .density_is_given = density_is_given,
                          .tests = tests},
                         judge);
}

const LaboratoryRow& Row(const LaboratorySheet& sheet, const std::string& key) {
  for (const LaboratoryRow& row : sheet.rows)
    if (row.key == key) return row;
  throw std::out_of_range(key);
}

std::optional<KnownTo> KnowsAll(const LogQuantity&, Resistance) { return KnownTo{0.5, 2.0, true}; }

// Bending along the warp is that of hinges whose edges lie along the weft, row 0 of the table, and
// the shear rigidity is half of c33.
TEST(FabricSheet, HasTheNumbersOfALaboratory) {
  const MaterialField tables = Tables();
  EXPECT_DOUBLE_EQ(tables.bend[0].b[0][0] / kBendPerRigidity, 16e-6);
  EXPECT_DOUBLE_EQ(tables.stretch[0].c[0][3] * kMembranePerEntry, 40.0);
  const LaboratorySheet sheet = Sheet(KnowsAll);
  const auto expect = [&](const char* key, double value, const char* unit) {
    EXPECT_NEAR(Row(sheet, key).value, value, 1e-9 * value) << key;
    EXPECT_EQ(Row(sheet, key).unit, unit) << key;
  };
  expect("mass_g_per_m2", 150, "g/m²");
  expect("bending_in_drape_un_m", (16 + 8 + 4) / 3.0, "µN·m");
  expect("bending_warp_un_m", 16, "µN·m");
  expect("bending_weft_un_m", 4, "µN·m");
  expect("bending_overall_un_m", 8, "µN·m");
  // c = ∛(B/(W·g)), 9.80665 m/s².
  expect("bending_length_warp_cm", 100 * std::cbrt(16e-6 / (0.15 * 9.80665)), "cm");
  expect("bending_length_overall_cm", 100 * std::cbrt(8e-6 / (0.15 * 9.80665)), "cm");
  expect("kes_b_weft_gf_cm2_per_cm", 4 / 98.0665, "gf·cm²/cm");
  expect("shear_n_per_m", 20, "N/m");
  expect("fast_eb5_percent", 123 / 20.0, "%");
  expect("kes_g_gf_per_cm_deg", 20 / 0.980665 * M_PI / 180, "gf/(cm·°)");
  // A strip that is free to contract: c22 − c12²/c11 = 588, c11 − c12²/c22 = 294 N/m.
  expect("fast_e100_warp_percent", 100 * 98.0665 / 588, "%");
  expect("fast_e5_weft_percent", 100 * 4.903325 / 294, "%");
  expect("kes_emt_weft_percent", 100 * 490.3325 / 294, "%");
  expect("fast_formability_warp_mm2", 16 * 100 * (19.6133 - 4.903325) / 588 / 14.7, "mm²");
}

// A strip of 294 N/m stretches by 6.7 % under FAST's 20 gf/cm and by 33 % under 100, of which FAST
// reads 20; one of 29 N/m by 1,670 % under the force of KES-FB1.
TEST(FabricSheet, ReadsNoMoreThanTheInstruments) {
  const LaboratorySheet sheet = Sheet(KnowsAll);
  const auto is_read = [](const LaboratoryRow& row) { return row.Reads(row.value); };
  EXPECT_TRUE(is_read(Row(sheet, "fast_e20_weft_percent")));
  EXPECT_TRUE(is_read(Row(sheet, "fast_formability_weft_mm2")));
  EXPECT_TRUE(is_read(Row(sheet, "fast_eb5_percent")));
  EXPECT_FALSE(is_read(Row(sheet, "fast_e100_weft_percent")));
  const LaboratorySheet soft = MakeFabricSheet({.tables = Scaled(Tables(), 0.1, 1.0),
                                                .law = MakeLaw("smooth"),
                                                .weights = EqualStiffnessWeights()},
                                               KnowsAll);
  for (const char* key : {"kes_emt_weft_percent", "fast_e20_weft_percent", "fast_eb5_percent",
                          "fast_formability_weft_mm2"})
    EXPECT_FALSE(is_read(Row(soft, key))) << key;
  // B·(E20 − E5)/14.7 with E20 = 20 % and E5 = 5 %.
  EXPECT_NEAR(*Row(soft, "fast_formability_weft_mm2").reads_up_to, 4 * 15 / 14.7, 1e-9);
  EXPECT_FALSE(Row(soft, "bending_warp_un_m").reads_up_to);
}

TEST(FabricSheet, SaysWhereANumberIsFrom) {
  const LaboratorySheet sheet = Sheet(KnowsAll);
  EXPECT_EQ(Row(sheet, "bending_warp_un_m").source, "measured");
  EXPECT_DOUBLE_EQ(Row(sheet, "bending_warp_un_m").interval->low, 8.0);
  EXPECT_DOUBLE_EQ(Row(sheet, "bending_warp_un_m").interval->high, 32.0);
  EXPECT_EQ(Row(sheet, "mass_g_per_m2").source, "given");
  const LaboratorySheet unweighed = Sheet(KnowsAll, false);
  EXPECT_EQ(Row(unweighed, "bending_warp_un_m").source, "measured, if the assumed mass is right");
  EXPECT_EQ(Row(unweighed, "bending_length_warp_cm").source, "measured");
  EXPECT_EQ(Row(unweighed, "mass_g_per_m2").source, "assumed: of the start tables");
}

LabMeasurement Cantilever(double direction, double overhang, double angle = 41.5) {
  return {.direction = direction, .sigma = 0.5, .points = {{overhang, angle}}};
}

// Half of each overhang at 41.5 degrees, B = W·g·c³ with 150 g/m², and geometric means, whatever
// the tables are.
TEST(FabricSheet, ARowOfAStandardIsWhatItsTestRead) {
  const auto expect = [](const LaboratorySheet& sheet, const std::string& key, double length) {
    const LaboratoryRow &c = Row(sheet, "bending_length_" + key + "_cm"),
                        &b = Row(sheet, "bending_" + key + "_un_m");
    EXPECT_NEAR(c.value, length, 2e-3) << key;
    EXPECT_NEAR(b.value, 0.15 * 9.80665 * std::pow(length, 3), 0.1) << key;
    EXPECT_EQ(c.source, "measured");
    EXPECT_EQ(b.source, "measured");
    EXPECT_GT(c.interval->low, 0.98 * length);
    EXPECT_LT(c.interval->high, 1.02 * length);
    EXPECT_NEAR(std::log(b.interval->high / b.value), 3 * std::log(c.interval->high / c.value),
                1e-9);
    EXPECT_NEAR(Row(sheet, "kes_b_" + key + "_gf_cm2_per_cm").value, b.value / 98.0665, 1e-9);
  };
  const LaboratorySheet sheet =
      Sheet(KnowsAll, true, {Cantilever(0, 0.06), Cantilever(45, 0.054), Cantilever(90, 0.048)});
  expect(sheet, "weft", 3.0);
  expect(sheet, "warp", 2.4);
  expect(sheet, "overall", std::sqrt(3.0 * 2.4));
  EXPECT_NEAR(Row(sheet, "bending_in_drape_un_m").value, (16 + 8 + 4) / 3.0, 1e-9);
  // One strip says nothing of the other direction, nor of the mean of both.
  const LaboratorySheet one = Sheet(KnowsAll, true, {Cantilever(0, 0.06)});
  expect(one, "weft", 3.0);
  EXPECT_NEAR(Row(one, "bending_warp_un_m").value, 16, 1e-9);
  EXPECT_NEAR(Row(one, "bending_overall_un_m").value, 8, 1e-9);
  EXPECT_EQ(Row(Sheet(KnowsAll, false, {Cantilever(0, 0.06)}), "bending_weft_un_m").source,
            "measured, if the assumed mass is right");
}

// Two strips that agree narrow the interval; two that do not widen it.
TEST(FabricSheet, StripsThatContradictOneAnotherAreLessCertain) {
  const auto width = [](const std::vector<LabMeasurement>& tests) {
    const LaboratorySheet sheet = Sheet(KnowsAll, true, tests);
    const LaboratoryRow::Interval c = *Row(sheet, "bending_length_weft_cm").interval;
    return std::log(c.high / c.low);
  };
  const double one = width({Cantilever(0, 0.06)});
  EXPECT_NEAR(width({Cantilever(0, 0.06), Cantilever(0, 0.06)}), one / std::sqrt(2), 1e-9);
  EXPECT_GT(width({Cantilever(0, 0.056), Cantilever(0, 0.064)}), 3 * one);
}

// A number from the prior has no interval.
TEST(FabricSheet, OnlyWhatIsMeasuredHasAnInterval) {
  for (const LaboratoryRow& row : Sheet([](const LogQuantity&, Resistance) {
                                    return std::optional(KnownTo{0.5, 2.0});
                                  }).rows)
    EXPECT_FALSE(row.interval) << row.key;
}

TEST(FabricSheet, ABoundHasOneSideAndNoRatio) {
  const Judgement judge = [](const LogQuantity&, Resistance) {
    return std::optional(KnownTo{0.5, 2.0, true, true});
  };
  const LaboratorySheet least = Sheet(JudgeByBound(judge, Bound::kAtLeast, Tables(), 1e-6));
  EXPECT_EQ(Row(least, "bending_overall_un_m").Text(),
            "bending rigidity B, overall at least 1 µN·m, measured");
  // A cube root has the cube root of an eighth.
  const double c = 100 * std::cbrt(8e-6 / (0.15 * 9.80665));
  EXPECT_NEAR(Row(least, "bending_length_overall_cm").value, c * 0.5, 1e-6);
  EXPECT_EQ(Row(least, "bending_warp_un_m").source, "from the prior");
  const LaboratorySheet most = Sheet(JudgeByBound(judge, Bound::kAtMost, Tables()));
  EXPECT_EQ(Row(most, "bending_overall_un_m").ValueText(), "at most 16");
  // What strips have measured has two sides.
  EXPECT_EQ(Row(Sheet(JudgeByBound(KnowsAll, Bound::kAtLeast, Tables())), "bending_warp_un_m")
                .IntervalText(),
            "8 … 32");
}

// Of a posterior of two factors, on all stretch and on all bend entries: bend is measured, but not
// how it differs between warp and weft, which the tables have from the start.
StoredPosterior Scales() {
  StoredPosterior posterior;
  posterior.fabric = ParameterTying::kScales;
  posterior.base = Tables();
  posterior.prior_sd = Eigen::Vector2d(1.0, 0.8);
  posterior.mean = Eigen::Vector2d::Zero();
  posterior.covariance = Eigen::Vector2d(0.01, 0.01).asDiagonal();
  return posterior;
}

TEST(FabricSheet, HasTheRatioOfAStifferAndASofterDirection) {
  const LaboratorySheet sheet = MakeFabricSheet({.tables = Tables(),
                                                 .law = MakeLaw("smooth"),
                                                 .weights = EqualStiffnessWeights(),
                                                 .directions = NameDirections(false, 16, 4)},
                                                KnowsAll);
  EXPECT_NEAR(Row(sheet, "bending_stiffer_un_m").value, 16, 1e-9);
  EXPECT_NEAR(Row(sheet, "bending_ratio").value, 4, 1e-9);
  EXPECT_EQ(Row(sheet, "bending_ratio").source, "measured");
  EXPECT_NEAR(Row(sheet, "fast_e100_stiffer_percent").value, 100 * 98.0665 / 588, 1e-9);
  EXPECT_EQ(NameDirections(false, 4, 16).warp, "softer");
  EXPECT_EQ(NameDirections(true, 4, 16).warp, "warp");
}

TEST(FabricSheet, APosteriorHasIntervals) {
  const LaboratorySheet sheet = Sheet(JudgeByPosterior(Scales(), false, 0.0));
  const LaboratoryRow& overall = Row(sheet, "bending_overall_un_m");
  EXPECT_EQ(overall.source, "measured");
  EXPECT_NEAR(overall.interval->low, 8 * std::exp(-0.1645), 0.15);  // of 1000 samples
  EXPECT_NEAR(overall.interval->high, 8 * std::exp(0.1645), 0.15);
  const LaboratoryRow& length = Row(sheet, "bending_length_overall_cm");
  EXPECT_NEAR(length.interval->high / length.value, std::exp(0.1645 / 3), 5e-3);
  EXPECT_EQ(Row(sheet, "bending_warp_un_m").source, "from the prior");
  EXPECT_FALSE(Row(sheet, "bending_warp_un_m").interval);
  // No silhouette measures stretching, however narrow its posterior; strips do.
  EXPECT_EQ(Row(sheet, "shear_n_per_m").source, "from the prior");
  EXPECT_EQ(Row(Sheet(JudgeByPosterior(Scales(), true)), "shear_n_per_m").source, "measured");
}

// What silhouettes leave uncertain is not hidden by a narrow posterior: it counts in full of a
// rigidity and by a third of a bending length, its cube root.
TEST(FabricSheet, ThePosteriorHasTheModelsErrorToo) {
  const LaboratorySheet sheet = Sheet(JudgeByPosterior(Scales(), false, 0.3));
  const double rigidity = 1.645 * std::hypot(0.1, 0.3);
  const LaboratoryRow& overall = Row(sheet, "bending_overall_un_m");
  EXPECT_NEAR(std::log(overall.interval->high / overall.value), rigidity, 0.01);
  EXPECT_NEAR(std::log(overall.value / overall.interval->low), rigidity, 0.01);
  const LaboratoryRow& length = Row(sheet, "bending_length_overall_cm");
  EXPECT_NEAR(std::log(length.interval->high / length.value), rigidity / 3, 0.004);
  // Once: a posterior that counts branches has it in its covariance.
  StoredPosterior of_branches = Scales();
  of_branches.branch_deviation = 0.3;
  const auto high = [](const StoredPosterior& posterior, double deviation) {
    return Row(Sheet(JudgeByPosterior(posterior, false, deviation)), "bending_overall_un_m")
        .interval->high;
  };
  EXPECT_EQ(high(of_branches, 0.3), high(Scales(), 0.0));
}

TEST(FabricSheet, WhatThePosteriorHasNotNarrowedIsFromThePrior) {
  StoredPosterior wide = Scales();
  wide.covariance = Eigen::Vector2d(1.0, 0.6).asDiagonal();  // .64 before
  EXPECT_EQ(Row(Sheet(JudgeByPosterior(wide, true)), "bending_overall_un_m").source,
            "from the prior");
}

// Two branches that count alike, one at the tables and one at bend stiffer by a factor.
LaboratorySheet OverBranches(double factor, double weight, bool by_outlines = true) {
  const double wide = std::exp(1.645 * 0.1);
  const Judgement judge = [=](const LogQuantity& quantity, Resistance) {
    const double degree = BendDegree(quantity, Tables());
    const double own = std::pow(wide, std::abs(degree));
    return std::optional(KnownTo{1 / own, own, true, by_outlines});
  };
  return Sheet(JudgeOverBranches(judge, Tables(),
                                 {{Tables(), 1.0}, {Scaled(Tables(), 1.0, factor), weight}}));
}

TEST(FabricSheet, BranchesThatDifferWidenTheInterval) {
  const LaboratorySheet one = OverBranches(1.0, 1.0);
  EXPECT_NEAR(Row(one, "bending_overall_un_m").value, 8.0, 1e-9);
  EXPECT_NEAR(Row(one, "bending_overall_un_m").interval->high, 8.0 * std::exp(0.1645), 1e-3);
  // Branches far apart: each end is a tenth of one of them, the value is between the two.
  const LaboratoryRow two = Row(OverBranches(4.0, 1.0), "bending_overall_un_m");
  EXPECT_NEAR(two.value, 16.0, 1e-2);
  EXPECT_NEAR(two.interval->low, 8.0 * std::exp(-0.12816), 1e-2);
  EXPECT_NEAR(two.interval->high, 32.0 * std::exp(0.12816), 1e-2);
  // The interval of a length is narrower by the cube root.
  const LaboratoryRow length = Row(OverBranches(4.0, 1.0), "bending_length_overall_cm");
  EXPECT_NEAR(length.interval->high / length.interval->low,
              std::cbrt(two.interval->high / two.interval->low), 1e-3);
  // A branch that hardly counts moves little; what strips have measured knows no branches.
  EXPECT_NEAR(Row(OverBranches(4.0, 1e-3), "bending_overall_un_m").value, 8.0, 1e-2);
  EXPECT_NEAR(Row(OverBranches(4.0, 1.0, false), "bending_overall_un_m").value, 8.0, 1e-9);
}

void ExpectEqual(const LinearFabric& a, const LinearFabric& b) {
  EXPECT_NEAR(a.c11, b.c11, 1e-12 * b.c11);
  EXPECT_NEAR(a.c22, b.c22, 1e-12 * b.c22);
  EXPECT_NEAR(a.c12, b.c12, 1e-12 * b.c12);
  EXPECT_NEAR(a.shear, b.shear, 1e-12 * b.shear);
  EXPECT_NEAR(a.bend_weft, b.bend_weft, 1e-12 * b.bend_weft);
  EXPECT_NEAR(a.bend_warp, b.bend_warp, 1e-12 * b.bend_warp);
  EXPECT_NEAR(a.bend_bias, b.bend_bias, 1e-12 * b.bend_bias);
  EXPECT_EQ(a.density, b.density);
}

TEST(LinearFabric, TablesOfALinearMaterialAreThatMaterial) {
  for (const char* law : {"smooth", "reference"})
    ExpectEqual(LineariseAtRest(TablesFrom(kTwill), MakeLaw(law)), kTwill);
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(kMaterialEntries, 0.0, 1.0);
  ExpectEqual(LineariseInDrape(TablesFrom(kTwill), MakeLaw("smooth"), weights), kTwill);
}

// The strip's formula for a sheet that has its rigidity along one direction.
TEST(LinearFabric, DirectionsAreThoseOfALaboratory) {
  LinearFabric material = kTwill;
  material.bend_weft = 5e-5;
  const BendTable bend = TablesFrom(material).bend[0];
  EXPECT_GT(DirectionalRigidity(bend, 0.0), 2.0 * DirectionalRigidity(bend, M_PI / 2));
}

// Of columns 10, 20, …: at zero the smooth law sees 3/4 of column 0 and 1/4 of column 1.
TEST(LinearFabric, RigidityIsThatOfTheCurvature) {
  MaterialField tables = TablesFrom(kTwill);
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) tables.bend[0].b[r][c] = 4e-6 * (r + 1) * (c + 1);
  const LinearFabric rest = LineariseAtRest(tables, MakeLaw("smooth"));
  EXPECT_NEAR(rest.bend_warp, 1.25e-6, 1e-18);
  EXPECT_NEAR(rest.bend_bias, 2.50e-6, 1e-18);
  EXPECT_NEAR(rest.bend_weft, 3.75e-6, 1e-18);
  EXPECT_NEAR(LineariseAtRest(tables, MakeLaw("reference")).bend_weft, 3e-6, 1e-18);
  // All energy of row 2 in column 3, none in row 0.
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(kMaterialEntries);
  weights[kStretchEntries + 2 * kBendCols + 3] = 0.7;
  const LinearFabric drape = LineariseInDrape(tables, MakeLaw("smooth"), weights);
  EXPECT_NEAR(drape.bend_weft, 12e-6, 1e-18);
  EXPECT_EQ(drape.bend_warp, rest.bend_warp);
}

TEST(LinearFabric, IsotropicSheetsKeepWhatIsAsked) {
  const LinearFabric exact = WithIsotropicMembrane(kTwill, {.mu = 30.0, .lambda = 50.0});
  for (const IsotropicChoice choice :
       {IsotropicChoice::kNearest, IsotropicChoice::kShear, IsotropicChoice::kStretch}) {
    const IsotropicSheet sheet = MakeIsotropic(exact, choice);
    EXPECT_NEAR(sheet.mu, 30.0, 1e-12);
    EXPECT_NEAR(sheet.lambda, 50.0, 1e-12);
  }
  const LinearFabric shear =
      WithIsotropicMembrane(kTwill, MakeIsotropic(kTwill, IsotropicChoice::kShear));
  EXPECT_NEAR(shear.shear, kTwill.shear, 1e-12);
  EXPECT_NEAR(shear.c11, 260.0, 1e-12);
  const LinearFabric stretch =
      WithIsotropicMembrane(kTwill, MakeIsotropic(kTwill, IsotropicChoice::kStretch));
  EXPECT_NEAR(stretch.c12, kTwill.c12, 1e-12);
  EXPECT_NEAR(stretch.c11, 260.0, 1e-12);
  // The nearest has a smaller distance than its neighbours.
  const IsotropicSheet nearest = MakeIsotropic(kTwill, IsotropicChoice::kNearest);
  const auto distance = [](double mu, double lambda) {
    const LinearFabric m = WithIsotropicMembrane(kTwill, {mu, lambda});
    return std::pow(m.c11 - kTwill.c11, 2) + std::pow(m.c22 - kTwill.c22, 2) +
           2.0 * std::pow(m.c12 - kTwill.c12, 2) + 4.0 * std::pow(m.shear - kTwill.shear, 2);
  };
  for (const double d : {-0.1, 0.1}) {
    EXPECT_LT(distance(nearest.mu, nearest.lambda), distance(nearest.mu + d, nearest.lambda));
    EXPECT_LT(distance(nearest.mu, nearest.lambda), distance(nearest.mu, nearest.lambda + d));
  }
  LinearFabric stiff = kTwill;
  stiff.shear = 500.0;
  EXPECT_EQ(MakeIsotropic(stiff, IsotropicChoice::kNearest).lambda, 0.0);
}

TEST(LinearFabric, MeanRigidityIsThatOfAllDirections) {
  const BendTable bend = TablesFrom(kTwill).bend[0];
  double mean = 0.0;
  constexpr int kDirections = 360;
  for (int i = 0; i < kDirections; ++i)
    mean += DirectionalRigidity(bend, M_PI * i / kDirections) / kDirections;
  EXPECT_NEAR(MeanRigidity(kTwill), mean, 1e-4 * mean);
}

}  // namespace
}  // namespace drape
