// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/validation/recovery.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "tests/losses/temp_folder.h"

namespace drape {
namespace {

// The summary of a fit whose every stiffness is `ratio` times the reference.
std::string Summary(const std::string& grade, double ratio, bool has_reference = true) {
  std::string stiffness;
  for (const char* key : {"c11_n_per_m", "c12_n_per_m", "c22_n_per_m", "c33_n_per_m",
                          "bend_along_weft_n_m", "bend_at_45_deg_n_m", "bend_along_warp_n_m",
                          "bend_n_m", "bend_over_weight_m3", "bending_length_m"})
    stiffness += Format("%s\"%s\": {\"fitted\": %.3g%s}", stiffness.empty() ? "" : ", ", key,
                        4.0 * ratio, has_reference ? ", \"reference\": 4.0" : "");
  return Format(R"({"verdict": {"grade": "%s", "bend_n_m": {"factor_90": 1.6}}, )", grade.c_str()) +
         "\"stiffness\": {" + stiffness + "}}";
}

class RecoveryTest : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& summary) {
    folders_.push_back(folder_ / name);
    std::filesystem::create_directories(folders_.back());
    WriteFileAtomically(folders_.back() + "/summary.json", summary);
  }

  TempFolder folder_;
  std::vector<std::string> folders_;
};

TEST_F(RecoveryTest, RatiosAreSortedAndInterpolated) {
  Write("a", Summary("good", 2.0));
  Write("b", Summary("usable", 0.5));
  Write("c", Summary("good", 1.0));
  Write("d", Summary("do not use", 9.0));
  const Recovery recovery = ReadRecovery(folders_);
  EXPECT_EQ(recovery.fits, 3);
  EXPECT_EQ(recovery.left_out, 1);
  for (const RecoveredQuantity& quantity : recovery.quantities) {
    EXPECT_EQ(quantity.ratios, (std::vector<double>{0.5, 1.0, 2.0})) << quantity.name;
    EXPECT_DOUBLE_EQ(quantity.Quantile(0.5), 1.0);
    EXPECT_DOUBLE_EQ(quantity.Quantile(0.75), 1.5);
  }
}

TEST_F(RecoveryTest, OnlyBendingIsClaimed) {
  Write("a", Summary("good", 1.0));
  const Recovery recovery = ReadRecovery(folders_);
  for (const RecoveredQuantity& quantity : recovery.quantities) {
    const double claim = quantity.name == "bend, as it drapes" ? 1.6
                         : quantity.name == "bending length"   ? std::cbrt(1.6)
                                                               : 0.0;
    EXPECT_DOUBLE_EQ(quantity.claimed_factor, claim) << quantity.name;
  }
  EXPECT_NE(RecoveryText(recovery).find("to 1.60 x     100 %"), std::string::npos)
      << RecoveryText(recovery);
}

TEST_F(RecoveryTest, RefusesFitsWithoutReference) {
  Write("a", Summary("good", 1.0, false));
  EXPECT_THROW(ReadRecovery(folders_), InputError);
}

TEST_F(RecoveryTest, RefusesFoldersWithoutUsableFits) {
  Write("a", Summary("do not use", 1.0));
  EXPECT_THROW(ReadRecovery(folders_), InputError);
  EXPECT_THROW(ReadRecovery({folder_ / "missing"}), InputError);
}

}  // namespace
}  // namespace drape
