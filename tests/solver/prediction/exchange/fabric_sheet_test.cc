// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <stdexcept>

#include "physics/material/material_scaling.h"
#include "solver/fit/effective_stiffness.h"
#include "solver/job/fit_verdict.h"
#include "solver/prediction/exchange/exchange_record.h"

namespace drape {
namespace {

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

LaboratorySheet Sheet(const Judgement& judge, bool density_is_given = true) {
  return MakeFabricSheet({.tables = Tables(),
                          .law = MakeLaw("smooth"),
                          .weights = EqualStiffnessWeights(),
                          .density_is_given = density_is_given},
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

TEST(FabricSheet, APosteriorHasIntervals) {
  const LaboratorySheet sheet = Sheet(JudgeByPosterior(Scales(), false));
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
}

TEST(FabricSheet, WhatThePosteriorHasNotNarrowedIsFromThePrior) {
  StoredPosterior wide = Scales();
  wide.covariance = Eigen::Vector2d(1.0, 0.6).asDiagonal();  // .64 before
  EXPECT_EQ(Row(Sheet(JudgeByPosterior(wide, true)), "bending_overall_un_m").source,
            "from the prior");
}

}  // namespace
}  // namespace drape
