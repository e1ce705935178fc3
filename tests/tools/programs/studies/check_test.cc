// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/check.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

const CheckRow* FindRow(const std::vector<CheckRow>& rows, const std::string& start,
                        const std::string& end) {
  const auto it = std::find_if(rows.begin(), rows.end(), [&](const CheckRow& row) {
    return row.name.starts_with(start) && row.name.ends_with(end);
  });
  return it == rows.end() ? nullptr : &*it;
}

MaterialField EqualRows() {
  MaterialField material = test::TestMaterial();
  auto& rows = material.stretch[0].c;
  for (auto& row : rows) std::copy(std::begin(rows[0]), std::end(rows[0]), std::begin(row));
  return material;
}

class CheckTest : public testing::TestWithParam<std::string> {
 protected:
  std::vector<CheckRow> Run(const MaterialField& material) {
    const auto model = test::SmallDisc(GetParam());
    return CheckScene(model, material, model->RestState(), {});
  }
};
INSTANTIATE_TEST_SUITE_P(Laws, CheckTest, testing::Values("reference", "smooth"),
                         [](const auto& info) { return info.param; });

TEST_P(CheckTest, HoldsForOurLaws) {
  for (const CheckRow& row : Run(test::TestMaterial()))
    EXPECT_TRUE(row.ok()) << row.group << ": " << row.name << " " << row.value;
}

TEST_P(CheckTest, ListsASweepOfSixStepsAndItsBest) {
  const auto rows = Run(test::TestMaterial());
  for (const char* name : {"K against differences", "tangent by the material",
                           "adjoint by the start", "bend, gravity, handles"}) {
    double best = 1.0;
    for (int exponent = 3; exponent <= 8; ++exponent) {
      const CheckRow* row = FindRow(rows, name, ", step 1e-" + std::to_string(exponent));
      ASSERT_NE(row, nullptr) << name;
      EXPECT_FALSE(row->has_bound());
      EXPECT_GT(row->value, 0.0);
      best = std::min(best, row->value);
    }
    const CheckRow* judged = FindRow(rows, name, "best step");
    ASSERT_NE(judged, nullptr) << name;
    EXPECT_EQ(judged->value, best);
    EXPECT_EQ(judged->bound, 1e-6);
  }
}

// A table that depends on the strain is no gradient: the mismatch is shown, not judged. One that
// does not is, and is judged.
TEST_P(CheckTest, JudgesTheStretchEnergyOnlyWhereThereIsOne) {
  const auto varied = Run(test::TestMaterial());
  EXPECT_EQ(FindRow(varied, "all with stretch: force = -gradient", ""), nullptr);
  const CheckRow* informs =
      FindRow(varied, "all with stretch (a table is no gradient)", "best step");
  ASSERT_NE(informs, nullptr);
  EXPECT_FALSE(informs->has_bound());
  EXPECT_GT(informs->value, 1e-5);

  const auto constant = Run(EqualRows());
  const CheckRow* judged = FindRow(constant, "all with stretch: force = -gradient", "best step");
  ASSERT_NE(judged, nullptr);
  EXPECT_TRUE(judged->has_bound());
  EXPECT_TRUE(AllPass(constant));
}

TEST_P(CheckTest, FailsWhenTheRolloutDoes) {
  MaterialField impossible = test::TestMaterial();
  impossible.density = -1.0;
  const auto rows = Run(impossible);
  EXPECT_FALSE(AllPass(rows));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_THAT(rows[0].name, testing::HasSubstr("step matrix not positive definite"));
}

TEST(CheckRows, HoldUpToTheirBound) {
  const CheckRow at = {"", "", 1e-6, 1e-6}, above = {"", "", 1.1e-6, 1e-6}, informs = {"", "", 9.0};
  const CheckRow not_a_number = {"", "", std::numeric_limits<double>::quiet_NaN(), 1e-6};
  EXPECT_TRUE(AllPass({at, informs}));
  EXPECT_FALSE(AllPass({at, above}));
  EXPECT_FALSE(not_a_number.ok());
}

}  // namespace
}  // namespace drape
