// SPDX-License-Identifier: Apache-2.0
// The reference values [MODEL, M53–M59] hold under both laws. Slow: strips of 1,500 vertices.
#include "solver/studies/validation/validation.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>

#include "physics/util/errors.h"

namespace drape {
namespace {

class ValidationTest : public testing::TestWithParam<std::tuple<std::string, std::string>> {};
INSTANTIATE_TEST_SUITE_P(All, ValidationTest,
                         testing::Combine(testing::Values("smooth", "reference"),
                                          testing::ValuesIn(ValidationGroups())),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" + std::get<1>(info.param);
                         });

TEST_P(ValidationTest, Holds) {
  const auto& [law, group] = GetParam();
  const std::vector<ReferenceCase> cases = Validate({.law = law, .only = {group}});
  ASSERT_FALSE(cases.empty());
  for (const ReferenceCase& one : cases) {
    EXPECT_EQ(one.group, group);
    ASSERT_EQ(one.computed.size(), 3u) << one.name;
    std::printf("%-10s %-48s %12.6g %12.6g %12.6g %12.6g  %8.1e of %7.0e  order %5.2f\n",
                group.c_str(), one.name.c_str(), one.expected, one.computed[0], one.computed[1],
                one.computed[2], one.Error(), one.tolerance, one.Order());
    EXPECT_TRUE(one.Holds()) << one.name << ": " << one.Error();
  }
}

ReferenceCase Measured(std::vector<double> computed) {
  return {.group = "g",
          .name = "n",
          .expected = 2.0,
          .tolerance = 0.01,
          .computed = std::move(computed),
          .scale = 2.0};
}

TEST(TruthTest, JudgesTheFinestMesh) {
  EXPECT_TRUE(Measured({5.0, 3.0, 2.015}).Holds());
  EXPECT_FALSE(Measured({2.0, 2.0, 2.03}).Holds());
  EXPECT_FALSE(Measured({2.0, 2.0, NAN}).Holds());
}

TEST(TruthTest, OrderIsThePowerOfTheMeshWidth) {
  EXPECT_NEAR(Measured({2.16, 2.04, 2.01}).Order(), 2.0, 1e-12);
  EXPECT_NEAR(Measured({2.4, 2.2, 2.1}).Order(), 1.0, 1e-12);
  EXPECT_TRUE(std::isnan(Measured({2.0, 2.0, 2.0}).Order()));
  EXPECT_TRUE(std::isnan(Measured({2.0, 2.1, 2.0}).Order()));
}

TEST(ValidationGroupsTest, UnknownNamesAreInputErrors) {
  ValidationOptions options;
  options.only = {"cusick"};
  try {
    Validate(options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("\"cusick\""));
    EXPECT_THAT(error.what(), testing::HasSubstr("cantilever"));
  }
}

}  // namespace
}  // namespace drape
