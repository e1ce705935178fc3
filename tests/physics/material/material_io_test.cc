// SPDX-License-Identifier: Apache-2.0
#include "physics/material/material_io.h"

#include <cstring>
#include <string>

#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kStretch[] =
    "[[1,2,3,4],[5,6,7,8],[9,10,11,12],[13,14,15,16],[17,18,19,20],[21,22,23,24]]";
constexpr char kBend[] = "[[1,2,3,4,5],[6,7,8,9,10],[11,12,13,14,15]]";
constexpr char kColumns[] =
    R"("c11":[1,2,3,4,5,6],"c12":[0,0,0,0,0,0],"c22":[7,7,7,7,7,7],"c33":[8,8,8,8,8,9])";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Ours(const std::string& convention) {
  return R"({"format":"drapefit-material","version":1,"name":"n","units":"SI","source":"s",)"
         R"("convention":")" +
         convention + R"(","density":0.2,"stretch":)" + kStretch + R"(,"bend":)" + kBend + "}";
}

std::string Arcsim() {
  return std::string(R"({"density":0.2,"stretching":)") + kStretch + R"(,"bending":)" + kBend + "}";
}

std::string Published() {
  return std::string(R"({"density":0.2,"density_prior_std":1,)") + kColumns +
         R"(,"c11_prior_std":[1],"bending":)" + kBend + "}";
}

class MaterialIo : public FileFixture {
 protected:
  Material Parse(const std::string& text, const std::string& pick = "",
                 const MaterialPolicy& policy = {}) const {
    return ReadMaterial(Write("m.json", text) + pick, policy);
  }
  void ExpectError(const std::string& text, const std::string& message,
                   const std::string& pick = "") const {
    EXPECT_INPUT_ERROR(Parse(text, pick), message);
  }
};

// The tables of the fixtures have rigidities of 1 to 15 N·m.
TEST_F(MaterialIo, NotesTablesInOtherUnits) {
  ::testing::internal::CaptureStderr();
  Parse(Replaced(Ours("mechanical"), "14,15]", "14,15.5]"));
  Parse(Replaced(Ours("mechanical"), "[[1,2,3,4],", "[[1,2,3,4e6],"));
  const std::string notes = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(notes,
              HasSubstr("m.json: largest bending rigidity: found 15.5 N*m, of fabrics expected "
                        "1e-09 … 0.1; in uN*m it would be 1.55e-05 N*m"));
  EXPECT_THAT(notes, HasSubstr("largest stretching stiffness: found 4e+06 N/m"));
}

TEST_F(MaterialIo, ReadsOurFormatInArcsimConvention) {
  const Material m = Parse(Ours("arcsim"));
  EXPECT_EQ(m.name, "n");
  EXPECT_EQ(m.source, "s");
  EXPECT_EQ(m.source_convention, "arcsim");
  EXPECT_EQ(m.field.density, .2);
  ASSERT_EQ(m.field.stretch.size(), 1u);
  ASSERT_EQ(m.field.bend.size(), 1u);
  EXPECT_THAT(m.field.stretch[0].c[1], ElementsAre(5, 6, 7, 8));
  EXPECT_THAT(m.field.bend[0].b[2], ElementsAre(11, 12, 13, 14, 15));
  EXPECT_THAT(m.warnings, IsEmpty());
}

TEST_F(MaterialIo, HalvesStretchAndTakesFourTimesRigidityInMechanicalConvention) {
  const Material m = Parse(Ours("mechanical"));
  EXPECT_EQ(m.source_convention, "mechanical");
  EXPECT_THAT(m.field.stretch[0].c[1], ElementsAre(2.5, 3, 3.5, 4));
  EXPECT_THAT(m.field.bend[0].b[2], ElementsAre(44, 48, 52, 56, 60));
}

TEST_F(MaterialIo, ReadsPublishedTablesColumnByColumn) {
  const Material m = Parse(Published());
  EXPECT_EQ(m.name, "m");
  EXPECT_EQ(m.source_convention, "arcsim");
  EXPECT_THAT(m.field.stretch[0].c[5], ElementsAre(6, 0, 7, 9));
  EXPECT_THAT(m.field.bend[0].b[0], ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(MaterialIo, PicksOneOfSeveral) {
  const std::string text =
      R"({"_about":{"what":"x"},"a":)" + Published() + R"(,"b":)" + Arcsim() + "}";
  EXPECT_EQ(Parse(text, "#a").name, "a");
  EXPECT_EQ(Parse(text, "#b").field.stretch[0].c[0][1], 2);
  ExpectError(text, "m.json: holds several fabrics, select one with '#name': a, b");
  ExpectError(text, "m.json: has no fabric 'c', found: a, b", "#c");
  EXPECT_EQ(Parse(R"({"only":)" + Arcsim() + "}").name, "only");
  EXPECT_EQ(Parse(Ours("arcsim"), "#n").name, "n");
  ExpectError(Ours("arcsim"), "m.json: has no fabric 'o', found: n", "#o");
}

TEST_F(MaterialIo, ReadsArcsimWithCommentsAndWarnsOfWhatItIgnores) {
  const Material m = Parse("// head\n" + Replaced(Arcsim(), "{", "{/* c */\"damping\":0,"));
  EXPECT_THAT(m.field.stretch[0].c[5], ElementsAre(21, 22, 23, 24));
  EXPECT_THAT(m.warnings, ElementsAre(HasSubstr("'damping' is ignored")));
}

TEST_F(MaterialIo, TheBuiltInFabricIsThatOfItsFile) {
  const Material built_in = ReadMaterial(kBuiltInName);
  const Material file =
      ReadMaterial(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_shirt.json");
  EXPECT_EQ(built_in.name, file.name);
  EXPECT_EQ(MaterialText(built_in), MaterialText(file));
}

TEST_F(MaterialIo, AFolderIsTheResultOfAFit) {
  EXPECT_INPUT_ERROR(ReadMaterial(Path("")), "found no material.json");
  WriteMaterial(Path("material.json"), ReadMaterial(kBuiltInName));
  EXPECT_EQ(MaterialText(ReadMaterial(Path(""))), MaterialText(ReadMaterial(kBuiltInName)));
}

TEST_F(MaterialIo, ALabelHasTheNameInTheFile) {
  EXPECT_EQ(MaterialLabel("x/a.json#felt"), "a#felt");
  EXPECT_EQ(MaterialLabel("x/a.json"), "a");
}

TEST_F(MaterialIo, ANumberIsNoFabric) {
  EXPECT_INPUT_ERROR(ReadMaterial("2"), "2: no such file; a fabric of the data set is named by");
}

TEST_F(MaterialIo, RejectsNegativeEntriesUnderTheSmoothLaw) {
  ExpectError(Replaced(Ours("arcsim"), "[5,6,7,8]", "[5,6,7,-8.5]"),
              "m.json: key 'stretch[1][3]': found -8.5, expected ≥ 0");
  ExpectError(Replaced(Arcsim(), "[6,7,8,9,10]", "[6,-7,8,9,10]"),
              "m.json: key 'bending[1][1]': found -7, expected ≥ 0");
  ExpectError(R"({"a":)" + Replaced(Published(), "[8,8,8,8,8,9]", "[8,8,-1,8,8,9]") + "}",
              "m.json: key 'a.c33[2]': found -1, expected ≥ 0");
}

TEST_F(MaterialIo, KeepsNegativeEntriesUnderTheReferenceLaw) {
  const Material m = Parse(Replaced(Published(), "[8,8,8,8,8,9]", "[8,8,-1.5,8,8,9]"), "",
                           {NegativeEntries::kWarn});
  EXPECT_EQ(m.field.stretch[0].c[2][3], -1.5);
  EXPECT_THAT(m.warnings, ElementsAre(HasSubstr("m.json: key 'c33[2]' = -1.5 is negative")));
}

TEST_F(MaterialIo, RejectsValuesThatAreNoStiffness) {
  const std::string ours = Ours("arcsim");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,null,3,4]"),
              "m.json: key 'stretch[0][1]': found null, expected a finite number");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,\"2\",3,4]"),
              "m.json: key 'stretch[0][1]': found \"2\", expected a finite number");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,NaN,3,4]"), "m.json: parse error at line 1");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,1e999,3,4]"), "m.json: number overflow");
  ExpectError(Replaced(ours, "0.2", "0"),
              "m.json: key 'density': found 0, expected 1e-05 to 1000 kg/m²");
  ExpectError(Replaced(ours, "0.2", "1e308"),
              "m.json: key 'density': found 1e+308, expected 1e-05");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,5.1e7,3,4]"),
              "m.json: key 'stretch[0][1]': found 51000000.0, expected at most 5e+07, far above");
  ExpectError(Replaced(ours, "[6,7,8,9,10]", "[6,7,401,9,10]"),
              "m.json: key 'bend[1][2]': found 401, expected at most 400, far above");
  ExpectError(Replaced(ours, "0.2", "-1"), "m.json: key 'density': found -1, expected 1e-05 to");
}

TEST_F(MaterialIo, RejectsWrongShapes) {
  const std::string ours = Ours("arcsim");
  ExpectError(Replaced(ours, "[1,2,3,4],", ""),
              "m.json: key 'stretch': found an array of 5, expected an array of 6");
  ExpectError(Replaced(ours, "[1,2,3,4]", "[1,2,3]"),
              "m.json: key 'stretch[0]': found an array of 3, expected an array of 4");
  ExpectError(Replaced(ours, "[6,7,8,9,10]", "[6,7,8,9]"),
              "m.json: key 'bend[1]': found an array of 4, expected an array of 5");
  ExpectError(Replaced(Published(), "[0,0,0,0,0,0]", "[0]"),
              "m.json: key 'c12': found an array of 1, expected an array of 6");
  ExpectError(Replaced(ours, kBend, "{}"),
              "m.json: key 'bend': found an object, expected an array");
  ExpectError("[]", "m.json: found an array of 0, expected an object");
}

TEST_F(MaterialIo, RejectsUnknownAndMissingKeys) {
  ExpectError(Replaced(Ours("arcsim"), "\"bend\"", "\"bends\""),
              "m.json: unknown key 'bends', allowed: format version name units source convention "
              "warp density stretch bend");
  ExpectError(Replaced(Arcsim(), "{", "{\"thicken\":2,"),
              "m.json: unknown key 'thicken', allowed: density stretching bending damping");
  ExpectError(R"({"a":)" + Replaced(Published(), "\"c22\"", "\"c21\"") + "}",
              "m.json: unknown key 'a.c21', allowed: density c11");
  ExpectError(Replaced(Ours("arcsim"), "\"density\":0.2,", ""), "m.json: key 'density' is missing");
  ExpectError(Replaced(Arcsim(), "{", "{\"density\":1,"), "m.json: key 'density' is given twice");
  ExpectError("{\"x\":1}", "m.json: no fabric found, expected key 'format'");
}

TEST_F(MaterialIo, RejectsOtherFormatsVersionsUnitsAndConventions) {
  const std::string ours = Ours("arcsim");
  ExpectError(Replaced(ours, "drapefit-material", "x"),
              "m.json: key 'format': found \"x\", expected \"drapefit-material\"");
  ExpectError(Replaced(ours, "\"version\":1", "\"version\":2"),
              "m.json: key 'version': found 2, expected 1");
  ExpectError(Replaced(ours, "\"version\":1", "\"version\":1.5"), "expected a whole number");
  ExpectError(Replaced(ours, "\"SI\"", "\"cgs\""), "key 'units': found \"cgs\", expected \"SI\"");
  ExpectError(Ours("arcsin"),
              "key 'convention': found \"arcsin\", expected \"mechanical\" or \"arcsim\"");
  ExpectError("{", "m.json: parse error at line 1");
  EXPECT_INPUT_ERROR(ReadMaterial(Path("absent.json#a")), "absent.json: no such file");
}

TEST_F(MaterialIo, ReadsBackWhatItWroteBitForBit) {
  for (const Convention convention : {Convention::kMechanical, Convention::kArcsim}) {
    Material m = Parse(Ours("arcsim"));
    m.name = "a \"quoted\" name";
    for (auto& row : m.field.stretch[0].c)
      for (double& c : row) c /= 3;
    for (auto& row : m.field.bend[0].b)
      for (double& b : row) b *= 1e-6 / 7;
    WriteMaterial(Path("out.json"), m, convention);
    EXPECT_EQ(MaterialText(ParseMaterial(MaterialText(m, convention), "text"), convention),
              MaterialText(m, convention));
    const Material again = ReadMaterial(Path("out.json"));
    EXPECT_EQ(again.name, m.name);
    EXPECT_EQ(again.source, "s");
    EXPECT_EQ(again.source_convention, convention == Convention::kArcsim ? "arcsim" : "mechanical");
    EXPECT_EQ(again.field.density, m.field.density);
    EXPECT_EQ(std::memcmp(&again.field.stretch[0], &m.field.stretch[0], sizeof(StretchTable)), 0);
    EXPECT_EQ(std::memcmp(&again.field.bend[0], &m.field.bend[0], sizeof(BendTable)), 0);
  }
}

TEST_F(MaterialIo, NamesATextInErrors) {
  EXPECT_INPUT_ERROR(ParseMaterial("{", "felt"), "felt: parse error at line 1");
  Material m = Parse(Ours("arcsim"));
  const std::string text = Replaced(MaterialText(m), "\"density\": ", "\"density\": -");
  EXPECT_INPUT_ERROR(ParseMaterial(text, "felt"), "felt: key 'density': found");
}

TEST(Fabrics, EachShippedFileIsReadable) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics")) {
    const Material m = ReadMaterial(entry.path().string(), {NegativeEntries::kWarn});
    EXPECT_EQ(m.name, entry.path().stem().string());
    EXPECT_NE(m.source, "");
    EXPECT_EQ(m.warnings.size(), m.name == "viscose_white" ? 2u : 0u) << m.name;
    ++count;
  }
  EXPECT_EQ(count, 9);
}

class MaterialFieldFile : public FileFixture {
 protected:
  MaterialFieldFile() {
    std::mt19937_64 random(4);
    material_.name = "scattered";
    material_.field = test::Scatter(test::TestMaterial(), mesh_, 0.3, random);
    WriteMaterialField(Path("field.json"), material_, mesh_);
  }
  // Writes a copy of the file with `from` replaced by `to`.
  std::string Changed(const std::string& from, const std::string& to) const {
    std::string text = Read(Path("field.json"));
    return Write("changed.json", text.replace(text.find(from), from.size(), to));
  }

  const Mesh mesh_ = MakeDisc({.target_vertices = 120});
  Material material_;
};

TEST_F(MaterialFieldFile, ComesBackBitForBit) {
  const Material again = ReadMaterialFor(mesh_, Path("field.json"));
  EXPECT_EQ(again.name, "scattered");
  EXPECT_EQ(again.field.density, material_.field.density);
  ASSERT_EQ(again.field.stretch.size(), material_.field.stretch.size());
  ASSERT_EQ(again.field.bend.size(), material_.field.bend.size());
  for (size_t f = 0; f < again.field.stretch.size(); ++f)
    for (int k = 0; k < kStretchEntries; ++k)
      ASSERT_EQ(again.field.stretch[f].entries()[k], material_.field.stretch[f].entries()[k]);
  for (size_t e = 0; e < again.field.bend.size(); ++e)
    for (int k = 0; k < kBendEntries; ++k)
      ASSERT_EQ(again.field.bend[e].entries()[k], material_.field.bend[e].entries()[k]);
}

TEST_F(MaterialFieldFile, AnotherMeshGetsTheNearestTables) {
  const Mesh fine = MakeDisc({.target_vertices = 400});
  const MaterialField field = ReadMaterialFor(fine, Path("field.json")).field;
  ASSERT_EQ(field.stretch.size(), static_cast<size_t>(fine.num_faces()));
  ASSERT_EQ(field.bend.size(), static_cast<size_t>(fine.num_hinges()));
  const Eigen::Vector2d place = FaceCentres(fine).col(100);
  Eigen::Index nearest;
  (FaceCentres(mesh_).colwise() - place).colwise().norm().minCoeff(&nearest);
  EXPECT_EQ(field.stretch[100].c[3][2], material_.field.stretch[nearest].c[3][2]);
}

TEST_F(MaterialFieldFile, AFileOfOneTableIsReadToo) {
  WriteMaterial(Path("one.json"), {.name = "one",
                                   .field = test::TestMaterial(),
                                   .source_convention = "arcsim",
                                   .source = "",
                                   .warnings = {}});
  EXPECT_EQ(ReadMaterialFor(mesh_, Path("one.json")).field.stretch.size(), 1u);
}

TEST_F(MaterialFieldFile, ErrorsNameTheKey) {
  EXPECT_INPUT_ERROR(ReadMaterialFor(mesh_, Changed("\"version\": 1", "\"version\": 2")),
                     "key 'version'");
  EXPECT_INPUT_ERROR(ReadMaterialFor(mesh_, Changed("mechanical", "arcsim")), "\"mechanical\"");
  EXPECT_INPUT_ERROR(ReadMaterialFor(mesh_, Changed("\"density\": 0", "\"density\": -0")),
                     "density");
  EXPECT_INPUT_ERROR(ReadMaterialFor(mesh_, Changed("\"stretch\": [\n[", "\"stretch\": [\n[-")),
                     "stretch[0][0]");
  EXPECT_INPUT_ERROR(
      ReadMaterialFor(mesh_, Changed("\"hinge_centres\": [[", "\"hinge_centres\": [[1, 2], [")),
      "bend");
  EXPECT_INPUT_ERROR(
      ReadMaterialFor(mesh_, Changed("\"hinge_centres\": [[", "\"hinge_centres\": [[\"x\", 2], [")),
      "hinge_centres[0][0]");
  EXPECT_INPUT_ERROR(ReadMaterialFor(mesh_, Changed("\"bend\"", "\"bending\"")), "bending");
}

}  // namespace
}  // namespace drape
