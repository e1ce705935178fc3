// SPDX-License-Identifier: Apache-2.0
// The reference values [MODEL, M53–M59] hold under both laws. Slow: strips of 1,500 vertices.
#include <gtest/gtest.h>

#include <cstdio>

#include "physics/simulation/statics/statics.h"
#include "tests/physics/simulation/reference/reference_case.h"

namespace drape {

void GoToRest(StepSolver& solver, const MaterialField& material, Eigen::VectorXd& x) {
  EquilibriumOptions options;
  options.tolerance = 1e-6;  // rounding of stiff hinges on triangles of 0.3 mm is 1e-7
  const EquilibriumResult rest = SolveEquilibrium(solver, material, x, options);
  x = rest.x;
  if (rest.status == EquilibriumStatus::kNotConverged)
    x.setConstant(std::numeric_limits<double>::quiet_NaN());
}

namespace {

struct Group {
  const char* name;
  std::vector<ReferenceCase> (*measure)(const Law&);
  std::size_t cases;
};
constexpr Group kGroups[] = {{"rigidity", RigidityCases, 6}, {"cantilever", CantileverCases, 10},
                             {"tip_load", TipLoadCases, 8},  {"hanging", HangingCases, 2},
                             {"uniaxial", UniaxialCases, 3}, {"disc", ClampedDiscCases, 1},
                             {"annulus", AnnulusCases, 2},   {"rigid", RigidMotionCases, 4},
                             {"turn", TurnCases, 1}};

class ReferenceCaseTest : public testing::TestWithParam<std::tuple<std::string, Group>> {};
INSTANTIATE_TEST_SUITE_P(All, ReferenceCaseTest,
                         testing::Combine(testing::Values("smooth", "reference"),
                                          testing::ValuesIn(kGroups)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" + std::get<1>(info.param).name;
                         });

TEST_P(ReferenceCaseTest, Holds) {
  const auto& [law, group] = GetParam();
  const std::vector<ReferenceCase> cases = group.measure(MakeLaw(law));
  EXPECT_EQ(cases.size(), group.cases);
  for (const ReferenceCase& one : cases) {
    ASSERT_EQ(one.computed.size(), 3u) << one.name;
    std::printf("%-10s %-48s %12.6g %12.6g %12.6g %12.6g  %8.1e of %7.0e  order %5.2f\n",
                group.name, one.name.c_str(), one.expected, one.computed[0], one.computed[1],
                one.computed[2], one.Error(), one.tolerance, one.Order());
    EXPECT_TRUE(one.Holds()) << one.name << ": " << one.Error();
  }
}

ReferenceCase Measured(std::vector<double> computed) {
  return {"n", 2.0, 0.01, 2.0, std::move(computed)};
}

TEST(ReferenceCase, JudgesTheFinestMesh) {
  EXPECT_TRUE(Measured({5.0, 3.0, 2.015}).Holds());
  EXPECT_FALSE(Measured({2.0, 2.0, 2.03}).Holds());
  EXPECT_FALSE(Measured({2.0, 2.0, NAN}).Holds());
}

TEST(ReferenceCase, OrderIsThePowerOfTheMeshWidth) {
  EXPECT_NEAR(Measured({2.16, 2.04, 2.01}).Order(), 2.0, 1e-12);
  EXPECT_NEAR(Measured({2.4, 2.2, 2.1}).Order(), 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(Measured({2.0, 2.0, 2.0}).Order()));
  EXPECT_TRUE(std::isnan(Measured({2.0, 2.1, 2.0}).Order()));
}

}  // namespace
}  // namespace drape
