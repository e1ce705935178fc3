// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "losses/metrics/laboratory_drape.h"

namespace drape {
namespace {

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
  EXPECT_THAT(text, testing::HasSubstr("8         4 … 16        µN·m        measured\n"));
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
      testing::HasSubstr("> 20        12 … > 20      %           from the prior, beyond the "
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

}  // namespace
}  // namespace drape
