// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/laboratory_drape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "physics/util/errors.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

constexpr int kAngles = 3600;

// r = mean + amplitude·cos(count·θ).
Eigen::VectorXd Waves(double mean, double amplitude, int count) {
  Eigen::VectorXd radius(kAngles);
  for (int k = 0; k < kAngles; ++k)
    radius[k] = mean + amplitude * std::cos(2 * M_PI * count * k / kAngles);
  return radius;
}

TEST(LaboratoryDrape, OfACircleHasNoNodes) {
  const LaboratoryDrape drape = MeasureLaboratoryDrape(Waves(0.12, 0, 0), {0.15, 0.09});
  // (.12² − .09²)/(.15² − .09²) and half way from the hem to the support.
  EXPECT_NEAR(drape.drape_coefficient, 43.75, 1e-9);
  EXPECT_NEAR(drape.distance_ratio, 50.0, 1e-9);
  EXPECT_TRUE(drape.nodes.empty());
  EXPECT_EQ(drape.fold_depth_index, 0.0);
  EXPECT_EQ(drape.severity_mean, 0.0);
  EXPECT_NEAR(drape.circularity, 1.0, 1e-5);
}

TEST(LaboratoryDrape, FindsTheNodesOfWaves) {
  const LaboratoryDrape drape = MeasureLaboratoryDrape(Waves(0.12, 0.01, 6), {0.15, 0.09});
  ASSERT_EQ(drape.nodes.size(), 6u);
  for (const DrapeNode& node : drape.nodes) {
    EXPECT_NEAR(std::remainder(node.angle, M_PI / 3), 0.0, 2e-3);
    EXPECT_NEAR(node.radius, 0.13, 1e-6);
    EXPECT_NEAR(node.height, 0.02, 1e-6);
    EXPECT_NEAR(node.width, 2 * 0.11 * std::sin(M_PI / 6), 1e-4);  // a chord of the valleys
  }
  EXPECT_NEAR(drape.spacing_mean, M_PI / 3, 1e-9);
  EXPECT_NEAR(drape.spacing_variation, 0.0, 2e-3);
  EXPECT_NEAR(drape.severity_mean, 0.02 / 0.11, 2e-4);
  EXPECT_NEAR(drape.severity_deviation, 0.0, 1e-4);
  EXPECT_NEAR(drape.fold_depth_index, 100 * 0.02 / 0.06, 1e-2);
  EXPECT_NEAR(drape.amplitude_ratio, 100 * 0.01 / 0.12, 1e-2);
  // ½∫r² = π(mean² + amplitude²/2).
  EXPECT_NEAR(drape.drape_coefficient, 100 * (0.0144 + 0.00005 - 0.0081) / 0.0144, 1e-6);
}

TEST(LaboratoryDrape, DependsOnTheDiscs) {
  const Eigen::VectorXd radius = Waves(0.12, 0.01, 6);
  const LaboratoryDrape large = MeasureLaboratoryDrape(radius, {0.18, 0.09});
  EXPECT_NEAR(large.drape_coefficient, 100 * (0.01445 - 0.0081) / (0.0324 - 0.0081), 1e-6);
  EXPECT_NEAR(large.distance_ratio, 100 * 0.06 / 0.09, 1e-6);
  EXPECT_NEAR(large.fold_depth_index, 100 * 0.02 / 0.09, 1e-2);
}

// Nodes of 60, 120 and 180° spacing: SD/mean = √(2·60²/3)/120.
TEST(LaboratoryDrape, TellsHowUnevenTheNodesAre) {
  Eigen::VectorXd radius = Eigen::VectorXd::Constant(kAngles, 0.11);
  for (const double degrees : {30.0, 90.0, 210.0})
    for (int k = 0; k < kAngles; ++k) {
      const double distance = std::remainder(k * 360.0 / kAngles - degrees, 360.0);
      radius[k] += 0.01 * std::exp(-0.5 * std::pow(distance / 8, 2));
    }
  const LaboratoryDrape drape = MeasureLaboratoryDrape(radius, {});
  ASSERT_EQ(drape.nodes.size(), 3u);
  EXPECT_NEAR(drape.spacing_mean, 2 * M_PI / 3, 1e-9);
  EXPECT_NEAR(drape.spacing_variation, std::sqrt(2 * 60.0 * 60.0 / 3) / 120, 2e-3);
}

// The smallest polygons that a profile can be: a square through its corners on two axes.
TEST(LaboratoryDrape, OfASquareHasItsCircularity) {
  Eigen::VectorXd radius(kAngles);
  for (int k = 0; k < kAngles; ++k) {
    const double angle = 2 * M_PI * k / kAngles;
    radius[k] = 0.12 / (std::abs(std::cos(angle)) + std::abs(std::sin(angle)));
  }
  const LaboratoryDrape drape = MeasureLaboratoryDrape(radius, {});
  EXPECT_NEAR(drape.circularity, M_PI / 4, 1e-4);
  EXPECT_EQ(drape.nodes.size(), 4u);
  EXPECT_NEAR(drape.nodes[1].severity(), drape.nodes[1].height / drape.nodes[1].width, 0.0);
}

// r = 12 cm + 1 cm·cos 6θ of a specimen of 36 cm on a support of 18 cm.
LaboratoryDrape Waves() {
  Eigen::VectorXd radius(3600);
  for (int k = 0; k < radius.size(); ++k) radius[k] = 0.12 + 0.01 * std::cos(M_PI * k / 300);
  return MeasureLaboratoryDrape(radius, {0.18, 0.09});
}

// Each in the unit of its name, from the outline by hand.
TEST(DrapeSheet, HasTheUnitsOfALaboratory) {
  std::map<std::string, LaboratoryRow> rows;
  for (const LaboratoryRow& row : DrapeSheet(Waves(), "drape").rows) rows[row.key] = row;
  const auto expect = [&](const std::string& key, double value, const std::string& unit) {
    ASSERT_TRUE(rows.contains(key)) << key;
    EXPECT_NEAR(rows[key].value, value, 2e-3 * value) << key;
    EXPECT_EQ(rows[key].unit, unit) << key;
    EXPECT_FALSE(rows[key].interval) << key;
  };
  expect("specimen_cm", 36, "cm");
  expect("support_cm", 18, "cm");
  expect("dc_percent", 100 * (0.01445 - 0.0081) / (0.0324 - 0.0081), "%");
  expect("nodes", 6, "");
  expect("node_spacing_deg", 60, "°");
  expect("node_severity", 0.02 / 0.11, "");
  expect("drape_distance_ratio_percent", 100 * 0.06 / 0.09, "%");
  expect("fold_depth_index_percent", 100 * 0.02 / 0.09, "%");
  expect("amplitude_ratio_percent", 100 * 0.01 / 0.12, "%");
  EXPECT_EQ(rows["dc_percent"].standard, "BS 5058, ISO 9073-9");
  EXPECT_EQ(rows["specimen_cm"].source, "given");
  EXPECT_EQ(rows["nodes"].source, "measured");
}

TEST(DrapeSheet, ListsTheNodes) {
  const nlohmann::ordered_json json = DrapeSheetJson(Waves(), "drape");
  EXPECT_EQ(json["title"], "drape");
  ASSERT_EQ(json["nodes"].size(), 6u);
  EXPECT_NEAR(json["nodes"][1]["angle_deg"], 60, 0.2);
  EXPECT_NEAR(json["nodes"][1]["height_mm"], 20, 0.01);
  EXPECT_NEAR(json["nodes"][1]["width_mm"], 110, 0.1);
  EXPECT_EQ(json["rows"][0]["low"], nullptr);
}

TEST(SheetText, ShowsTheRowsThatAreAskedFor) {
  const LaboratorySheet sheet{"Sheet",
                              {{.key = "b_un_m",
                                .name = "bending rigidity",
                                .value = 8.0,
                                .unit = "µN·m",
                                .interval = {{4.0, 16.0}},
                                .source = "measured"},
                               {.key = "g",
                                .name = "shear",
                                .value = 2,
                                .unit = "N/m",
                                .interval = {},
                                .source = "given"}}};
  const std::string text = SheetText(sheet, {"b_un_m"});
  EXPECT_THAT(text, testing::HasSubstr("8  4 … 16               µN·m        measured\n"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("shear")));
  EXPECT_THAT(SheetText(sheet), testing::HasSubstr("shear"));
}

// An instrument that reads up to 20 % prints no 40,000 %.
TEST(Sheet, SaysWhatIsBeyondTheInstrument) {
  LaboratoryRow row{.key = "e",
                    .name = "extension",
                    .value = 40321.0,
                    .unit = "%",
                    .interval = {{12.0, 9e5}},
                    .source = "from the prior",
                    .reads_up_to = 20.0};
  EXPECT_THAT(
      SheetText({"Sheet", {row}}),
      testing::HasSubstr("> 20  12 … > 20            %           from the prior, beyond the "
                         "instrument's range\n"));
  nlohmann::ordered_json json = SheetJson({"Sheet", {row}})["rows"][0];
  EXPECT_EQ(json["value"], nullptr);
  EXPECT_EQ(json["low"], 12.0);
  EXPECT_EQ(json["high"], nullptr);
  EXPECT_EQ(json["reads_up_to"], 20.0);
  EXPECT_EQ(json["note"], "beyond the instrument's range: > 20 %");
  row.value = 20.0;
  json = SheetJson({"Sheet", {row}})["rows"][0];
  EXPECT_EQ(json["value"], 20.0);
  EXPECT_FALSE(json.contains("note"));
}

// What bounds a quantity from one side only has the bound as its value, in no file a number that a
// reader could take for an estimate, and survives the way through a file.
TEST(Sheet, ABoundIsNoEstimate) {
  const double infinity = std::numeric_limits<double>::infinity();
  LaboratoryRow row{.key = "b",
                    .name = "bending rigidity",
                    .value = 371.4,
                    .unit = "µN·m",
                    .interval = {{371.4, infinity}},
                    .source = kMeasured};
  EXPECT_EQ(row.Text(), "bending rigidity at least 371 µN·m, measured");
  EXPECT_EQ(RowJson(row)["value"], nullptr);
  EXPECT_EQ(RowJson(row)["text"], "at least 371");
  // Numbers of a laboratory have no exponents as long as they are below a million.
  row.value = 40321.4;
  row.interval = {{766.2, 1354.3}};
  EXPECT_EQ(row.Text(), "bending rigidity 40321 µN·m (766 … 1354), measured");
  row.value = 8;
  row.interval = {{-infinity, 8}};
  EXPECT_EQ(row.ValueText(), "at most 8");
  row.interval = {{4, 16}};
  EXPECT_EQ(row.Text(), "bending rigidity 8 µN·m (4 … 16), measured");
  EXPECT_THROW(LaboratorySheet({"Sheet", {row}}).of("c"), InputError);
}

class ReadSheetTest : public FileFixture {};
TEST_F(ReadSheetTest, GivesTheRowsBack) {
  const double infinity = std::numeric_limits<double>::infinity();
  LaboratorySheet sheet{"Sheet",
                        {{.key = "a", .name = "A", .value = 1.5, .source = kFromThePrior}}};
  sheet.rows.push_back(sheet.rows[0]);
  sheet.rows[1].interval = {{1.0, 2.0}};
  sheet.rows.push_back(sheet.rows[0]);
  sheet.rows[2].interval = {{1.5, infinity}};
  sheet.rows.push_back(sheet.rows[0]);
  sheet.rows[3].interval = {{-infinity, 1.5}};
  EXPECT_FALSE(ReadSheet(Path(""), "material"));
  Write("summary.json", nlohmann::json{{"laboratory", {{"material", SheetJson(sheet)}}}}.dump());
  EXPECT_FALSE(ReadSheet(Path(""), "linear"));
  const LaboratorySheet read = ReadSheet(Path(""), "material").value();
  ASSERT_EQ(read.rows.size(), sheet.rows.size());
  for (std::size_t i = 0; i < read.rows.size(); ++i)
    EXPECT_EQ(read.rows[i].Text(), sheet.rows[i].Text());
}

}  // namespace
}  // namespace drape
