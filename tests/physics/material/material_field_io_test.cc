// SPDX-License-Identifier: Apache-2.0
#include "physics/material/material_io.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

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
