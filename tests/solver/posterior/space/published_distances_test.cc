// SPDX-License-Identifier: Apache-2.0
// The published table of distances between materials [Gong 2024, table 4] follows from start values
// alone [METHODS, P63].
#include <gtest/gtest.h>

#include <string>

#include "physics/material/material_io.h"
#include "solver/posterior/space/normal_mixture.h"

namespace drape::test {
namespace {

// Deviations of the released programs: of cotton blue, of the others, and the one that a fit's
// smallest becomes by the softplus function.
constexpr double kBlueDeviation = 1e-4, kLeastDeviation = 9.992007e-14;

StretchTable StartTable(const std::string& name) {
  return ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/" + name + ".json",
                      {NegativeEntries::kWarn})
      .field.stretch[0];
}

// The material `paper` of ARCSim.
StretchTable Paper() {
  StretchTable paper;
  for (auto& row : paper.c) row[0] = row[2] = row[3] = 5e5;
  return paper;
}

NormalDistribution AsNormal(const StretchTable& table, double deviation) {
  return {Eigen::Map<const Eigen::VectorXd>(table.entries(), kStretchEntries),
          deviation * deviation * Eigen::MatrixXd::Identity(kStretchEntries, kStretchEntries)};
}

double Distance(const std::string& fabric, const StretchTable& sample) {
  const double deviation = fabric == "cotton_blue" ? kBlueDeviation : kLeastDeviation;
  return KullbackLeibler(AsNormal(StartTable(fabric), deviation),
                         AsNormal(sample, kLeastDeviation));
}

// To the printed digits.
void ExpectPrinted(double computed, double printed) {
  EXPECT_NEAR(computed / printed, 1.0, 5.1e-4) << printed;
}

TEST(PublishedDistances, FollowFromStartValues) {
  // Linen green was started with the table of cotton blue.
  const StretchTable linen = StartTable("cotton_blue");
  ExpectPrinted(Distance("cotton_white", linen), 8.669e30);
  ExpectPrinted(Distance("cotton_blue", linen), 1.202e19);
  ExpectPrinted(Distance("viscose_white", linen), 9.796e30);
  ExpectPrinted(Distance("cotton_pink", linen), 7.307e30);
  ExpectPrinted(Distance("cotton_white", Paper()), 2.253e38);
  ExpectPrinted(Distance("cotton_blue", Paper()), 2.253e38);
  ExpectPrinted(Distance("viscose_white", Paper()), 2.254e38);
  ExpectPrinted(Distance("cotton_pink", Paper()), 2.252e38);
  ExpectPrinted(Distance("wool_red", Paper()), 2.253e38);
  // The tenth: the released start table of wool differs from the published one.
  EXPECT_NEAR(Distance("wool_red", linen), 7.524e29, 1e26);
}

}  // namespace
}  // namespace drape::test
