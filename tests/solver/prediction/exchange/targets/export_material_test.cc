// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/targets/export_material.h"

#include <nlohmann/json.hpp>

#include "physics/cloth/assembly/assembly.h"
#include "physics/material/material_io.h"
#include "physics/util/json_input.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class ExportMaterialTest : public FileFixture {
 protected:
  static ExchangeRecord Record(std::optional<double> thickness = {}) {
    FabricSource source;
    source.material.name = "twill \"7\"";
    source.material.field = test::TestMaterial();
    RecordOptions options;
    options.thickness = thickness;
    return MakeRecord(source, MakeLaw("smooth"), options);
  }
  static nlohmann::json Parsed(ExportTarget target, const ExchangeRecord& record) {
    return ParseJson(ExportMaterial(target, record).text, "file");
  }
};

TEST_F(ExportMaterialTest, ArcsimReadsBackBitForBit) {
  const ExchangeRecord record = Record();
  const ExportedMaterial exported = ExportMaterial(ExportTarget::kArcsim, record);
  const Material back = ReadMaterial(Write("arcsim.json", exported.text));
  EXPECT_EQ(back.source_convention, "arcsim");
  EXPECT_TRUE(back.warnings.empty());
  EXPECT_EQ(back.field.density, record.source.material.field.density);
  for (int i = 0; i < kStretchEntries; ++i)
    EXPECT_EQ(back.field.stretch[0].entries()[i],
              record.source.material.field.stretch[0].entries()[i]);
  for (int i = 0; i < kBendEntries; ++i)
    EXPECT_EQ(back.field.bend[0].entries()[i], record.source.material.field.bend[0].entries()[i]);
  EXPECT_TRUE(exported.lost.empty());
}

TEST_F(ExportMaterialTest, CloHasItsUnits) {
  const ExchangeRecord record = Record(0.4e-3);
  const nlohmann::json fabric = Parsed(ExportTarget::kClo, record).at("mapPhysical");
  const LinearFabric& m = record.material;
  EXPECT_DOUBLE_EQ(fabric.at("fSuK").get<double>(), 1e3 * m.c11);
  EXPECT_DOUBLE_EQ(fabric.at("fSvK").get<double>(), 1e3 * m.c22);
  EXPECT_DOUBLE_EQ(fabric.at("fHK").get<double>(), 1e3 * m.shear);
  EXPECT_DOUBLE_EQ(fabric.at("fBuK").get<double>(), 1e9 * m.bend_weft);
  EXPECT_DOUBLE_EQ(fabric.at("fBvK").get<double>(), 1e9 * m.bend_warp);
  EXPECT_DOUBLE_EQ(fabric.at("fBhK").get<double>(), 1e9 * m.bend_bias);
  EXPECT_DOUBLE_EQ(fabric.at("fDensity").get<double>(), 1e-3 * m.density);
  EXPECT_DOUBLE_EQ(fabric.at("fThickness").get<double>(), 0.4);
  const auto without = ExportMaterial(ExportTarget::kClo, Record());
  EXPECT_THAT(without.lost, testing::Contains(testing::HasSubstr("--thickness")));
}

TEST_F(ExportMaterialTest, EveryTargetSaysWhatIsLostAndHowFarItIsVerified) {
  for (const ExportTarget target : kExportTargets) {
    const ExportedMaterial exported = ExportMaterial(target, Record());
    EXPECT_FALSE(exported.text.empty());
    EXPECT_EQ(exported.text.back(), '\n');
    EXPECT_FALSE(exported.evidence.empty());
    EXPECT_FALSE(exported.use.empty());
    EXPECT_EQ(exported.lost.empty(), target == ExportTarget::kArcsim);
    EXPECT_EQ(exported.tables.density, test::TestMaterial().density);
    EXPECT_EQ(exported.text.find('\t'), std::string::npos);
  }
}

}  // namespace
}  // namespace drape
