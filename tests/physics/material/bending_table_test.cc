// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "physics/material/material_io.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kNames[] =
    "density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear diag[SI*1e9], "
    "nonlinear warp[SI*1e12], nonlinear weft[SI*1e12], nonlinear diag[SI*1e12]\n";
// Invented numbers.
constexpr char kRows[] =
    "0.1, 1000, 2000, 3000, -10, -20, -30\n"
    "0.25, 5000.5, 600, 700, 0, 1e3, -1e4\n";
constexpr char kBase[] =
    R"({"density":0.9,"stretching":[[1,2,3,4],[5,6,7,8],[9,10,11,12],[13,14,15,16],[17,18,19,20],)"
    R"([21,22,23,24]],"bending":[[1,1,1,1,1],[1,1,1,1,1],[1,1,1,1,1]]})";

class BendingTable : public FileFixture {
 protected:
  BendingTable() {
    Write("set.csv", std::string(kNames) + kRows);
    Write("base.json", kBase);
  }
  Material Read(const std::string& row, const MaterialPolicy& policy = {}) const {
    return ReadMaterial(Path("set.csv") + "#" + row + ":" + Path("base.json"), policy);
  }
};

// entry = 4 (B1 + 10 k B2) of warp, diagonal, weft: by hand from the numbers above.
TEST_F(BendingTable, EntriesAreFourTimesTheSecantStiffness) {
  const Material m = Read("1");
  EXPECT_EQ(m.field.density, 0.1);
  const double warp[] = {4e-6, 3.9996e-6, 3.9992e-6, 3.9988e-6, 3.9984e-6};
  const double diagonal[] = {12e-6, 11.9988e-6, 11.9976e-6, 11.9964e-6, 11.9952e-6};
  const double weft[] = {8e-6, 7.9992e-6, 7.9984e-6, 7.9976e-6, 7.9968e-6};
  for (int k = 0; k < kBendCols; ++k) {
    EXPECT_NEAR(m.field.bend[0].b[0][k], warp[k], 1e-18) << k;
    EXPECT_NEAR(m.field.bend[0].b[1][k], diagonal[k], 1e-18) << k;
    EXPECT_NEAR(m.field.bend[0].b[2][k], weft[k], 1e-18) << k;
  }
  EXPECT_THAT(m.field.stretch[0].c[1], ElementsAre(5, 6, 7, 8));
  EXPECT_EQ(m.name, "set#1");
  EXPECT_THAT(m.source, HasSubstr("stretch of base"));
}

TEST_F(BendingTable, ColumnsMayStandInAnyOrder) {
  Write("set.csv",
        "extra,nonlinear warp[SI*1e12],density[kg.m-2],linear diag[SI*1e9],linear warp[SI*1e9],"
        "nonlinear diag[SI*1e12],linear weft[SI*1e9],nonlinear weft[SI*1e12]\r\n"
        "\n7,-10,0.1,3000,1000,-30,2000,-20\r\n");
  const Material m = Read("1");
  EXPECT_NEAR(m.field.bend[0].b[2][4], 7.9968e-6, 1e-18);
  EXPECT_NEAR(m.field.bend[0].b[0][1], 3.9996e-6, 1e-18);
}

TEST_F(BendingTable, MistakesNameTheFileAndWhatWasExpected) {
  const std::string row = Path("set.csv") + "#2";
  EXPECT_INPUT_ERROR(ReadMaterial(row), "set.csv#2: has bending alone, expected ");
  EXPECT_INPUT_ERROR(ReadMaterial(row + ":" + row), "expected a material file with stretch");
  EXPECT_INPUT_ERROR(ReadMaterial(row + ":" + Path("no.json")), "no.json: no such file");
  EXPECT_INPUT_ERROR(ReadMaterial(Path("set.csv")), "select a row with '#1'");
  EXPECT_INPUT_ERROR(ReadMaterial(Path("absent.csv#1")), "absent.csv: no such file");
  for (const char* wrong : {"0", "3", "-1", "x", "1.5", ""})
    EXPECT_INPUT_ERROR(Read(wrong),
                       "set.csv: has no row '" + std::string(wrong) + "', expected 1 to 2");
  Write("set.csv", std::string(kNames).substr(0, 60) + "\n" + "1,2,3\n");
  EXPECT_INPUT_ERROR(Read("1"),
                     "set.csv:1: column 'linear diag[SI*1e9]' is missing, found: density");
  Write("set.csv", std::string(kNames) + "0.1,1,2,3,4,5\n");
  EXPECT_INPUT_ERROR(Read("1"), "set.csv:2: found 6 fields, expected 7");
  Write("set.csv", std::string(kNames) + "0.1,1,2,three,4,5,6\n");
  EXPECT_INPUT_ERROR(Read("1"), "set.csv:2: column 'linear diag[SI*1e9]': found 'three'");
  Write("set.csv", std::string(kNames) + "0,1,2,3,4,5,6\n");
  EXPECT_INPUT_ERROR(Read("1"), "set.csv#1: found a density of 0, expected 1e-05 to 1000 kg/m²");
  Write("set.csv", "");
  EXPECT_INPUT_ERROR(Read("1"), "set.csv: is empty");
}

TEST_F(BendingTable, AStiffnessThatTurnsNegativeIsRefusedOrKept) {
  Write("set.csv", std::string(kNames) + "0.1,1000,2000,3000,-30000,0,0\n");
  EXPECT_INPUT_ERROR(Read("1"), "set.csv#1: found a rigidity of -2e-07 N m within 40 /m");
  const Material kept = Read("1", {NegativeEntries::kWarn});
  EXPECT_NEAR(kept.field.bend[0].b[0][4], -0.8e-6, 1e-18);
  EXPECT_EQ(kept.warnings.size(), 1u);
  EXPECT_THAT(Read("1", {.min_relative_stiffness = 0.1}).warnings,
              ElementsAre(HasSubstr("raised")));
}

TEST_F(BendingTable, ALabelHasTheRowButNotItsBase) {
  EXPECT_FALSE(SplitBendingRow("folder.csv#1/a.json"));
  EXPECT_EQ(MaterialLabel("x/a.csv#3:y/c.json"), "a#3");
  EXPECT_EQ(MaterialLabel("x/a.json#felt"), "a#felt");
  EXPECT_EQ(MaterialLabel("x/a.json"), "a");
}

}  // namespace
}  // namespace drape
